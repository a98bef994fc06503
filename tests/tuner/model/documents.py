"""Model documents for the tests, written here."""

import tomllib

from tuner.model import model_filter, template


def made(text):
    """The filter class of a document's text."""
    return model_filter(tomllib.loads(text))


def of_kind(kind):
    """The filter class of a template."""
    return made(template(kind))


SHORT = """
states = ["level"]
measurements = ["z"]
[parameters]
q = {}
R = {}
[model]
A = 0
Q = "q"
C = 1
R = "R"
"""

GPS = """
[parameters]
q = { start = 0.2, unit = "m^2/s^3" }
s = { start = 1.0, unit = "" }
[inputs]
accuracy = { unit = "m" }
[states]
x = { unit = "m" }
vx = { unit = "m/s" }
y = { unit = "m" }
vy = { unit = "m/s" }
[measurements.gps]
axes = ["x", "y"]
unit = "m"
h = ["x", "y"]
R = "(s * accuracy)^2"
[model]
time = "continuous"
f = ["vx", "0", "vy", "0"]
G = [[0, 0], [1, 0], [0, 0], [0, 1]]
Q = "q"
"""

VERTICAL = """
[parameters]
q_acc = { start = 0.04, unit = "m^2/s^3" }
q_bias = { start = 1e-4, unit = "m^2/s^5" }
R_baro = { start = 0.1, unit = "m^2" }
[inputs]
acc = { unit = "m/s^2" }
[states]
height = { unit = "m" }
climb = { unit = "m/s" }
bias = { unit = "m/s^2" }
[measurements]
baro = { unit = "m", h = "height", R = "R_baro" }
[model]
time = "continuous"
f = { height = "climb", climb = "acc - bias", bias = "0" }
G = [[0, 0], [1, 0], [0, 1]]
Q = ["q_acc", "q_bias"]
P0 = { height = inf, climb = 1.0, bias = 1.0 }
"""

ROBOT = """
[parameters]
q_speed = { start = 0.1, low = 1e-6, high = 1e3, unit = "m^2/s" }
q_turn = { start = 0.01, low = 1e-8, high = 10, unit = "rad^2/s" }
R = { start = 1.0, low = 1e-6, high = 1e4, unit = "m^2" }
[inputs]
speed = { unit = "m/s" }
turn = { unit = "rad/s" }
[states]
x = { unit = "m" }
y = { unit = "m" }
heading = { unit = "rad", angle = true }
[measurements]
gps = { unit = "m", axes = ["x", "y"], h = ["x", "y"], R = "R" }
[model]
time = "discrete"
f.x = "x + dt * speed * cos(heading)"
f.y = "y + dt * speed * sin(heading)"
f.heading = "heading + dt * turn"
G = [["cos(heading)", 0], ["sin(heading)", 0], [0, 1]]
Q = ["q_speed * dt", "q_turn * dt"]
P0 = [25, 25, 10]
"""

OSCILLATOR = """
[parameters]
omega = { start = 3.0, low = 0.1, high = 30, unit = "rad/s", smaller = "slower", larger = "faster" }
damping = { start = 0.1, low = 1e-3, high = 1, unit = "", smaller = "rings", larger = "dies out" }
q = { start = 0.5, low = 1e-6, high = 1e3, unit = "m^2/s^3", smaller = "calm", larger = "shaken" }
r = { start = 0.3, low = 1e-6, high = 1e3, unit = "m^2", smaller = "trusted", larger = "smoothed" }
[inputs]
force = { unit = "m/s^2" }
[states]
x = { unit = "m" }
v = { unit = "m/s" }
[measurements]
left = { unit = "m", H = [1, 0.2] }
right = { unit = "m", H = [0.5, 1] }
[model]
A = [[0, 1], ["-omega^2", "-2*damping*omega"]]
B = [[0], [1]]
G = [[0], [1]]
Q = [["q"]]
R = [["r", "0.4*r"], ["0.4*r", "2*r"]]
x0 = [0.1, -0.2]
P0 = [[1, 0.2], [0.2, 0.5]]
"""

COMPASS = """
[parameters]
q = { start = 0.1, low = 1e-6, high = 1e2, unit = "rad^2/s^3" }
R = { start = 0.04, low = 1e-6, high = 1e2, unit = "rad^2" }
[states]
heading = { unit = "rad", angle = true }
rate = { unit = "rad/s" }
[measurements]
compass = { unit = "rad", angle = true, h = "heading", R = "R" }
[model]
A = [[0, 1], [0, 0]]
G = [0, 1]
Q = "q"
"""

WHEELS = """
[parameters]
q_speed = { start = 0.1, unit = "m^2/s", smaller = "trusts the wheels", larger = "follows fixes" }
q_turn = { start = 0.01, unit = "rad^2/s", smaller = "trusts the gyroscope", larger = "turns" }
sigma = { start = 1.0, unit = "", smaller = "follows fixes", larger = "smooths them" }
[inputs]
speed = { unit = "m/s" }
turn = { unit = "rad/s" }
accuracy = { unit = "m" }
[states]
x = { unit = "m" }
y = { unit = "m" }
heading = { unit = "rad", angle = true }
[measurements]
gps = { unit = "m", axes = ["x", "y"], h = ["x", "y"], R = "(sigma * accuracy)^2" }
compass = { unit = "rad", angle = true, h = "heading", R = 0.25 }
[model]
time = "continuous"
f = { x = "speed * cos(heading)", y = "speed * sin(heading)", heading = "turn" }
G = [["cos(heading)", 0], ["sin(heading)", 0], [0, 1]]
Q = ["q_speed", "q_turn"]
x0 = { heading = 0.3 }
P0 = [2.0, 2.0, 0.5]
"""
