"""Which filter does best where: what docs/fit.md says of the three."""

from benchmarks.nonlinear import CASES, filters, measured

FAR, VAGUE, POOR = CASES


def test_each_filter_has_its_case():
    own = filters()
    vague = {name: measured(own[name], VAGUE, 40, 60) for name in ("extended", "iterated")}
    assert vague["iterated"].rms < 0.4 * vague["extended"].rms
    poor = {name: measured(own[name], POOR, 40, 60) for name in ("extended", "unscented")}
    assert poor["unscented"].rms < 0.5 * poor["extended"].rms
    assert poor["unscented"].nees < 1.2
    assert poor["extended"].nees > 5
    far = {name: measured(own[name], FAR, 40, 60) for name in ("extended", "unscented")}
    assert abs(far["unscented"].rms / far["extended"].rms - 1) < 0.02
