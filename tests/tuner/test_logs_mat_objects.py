"""Objects of MATLAB, as the package mat-io 1.0.2 wrote them into a file of version 7."""

import base64

import numpy as np
import pytest

from tests.tuner.recordings import refusal
from tuner.data import mat
from tuner.data.logs.formats import open_table
from tuner.data.logs.mat import not_read
from tuner.data.mat_objects import Objects, columns_of
from tuner.data.reading import read_record

START = 1_700_000_000_000_000_000
# Two timetables, by dates and by durations, a table, a datetime, a string and a vector.
FILE = base64.b85decode(
    """
O+i#lK|&xkE-)ZXK~ybfX>4U6P;6mzW^ZzBE+9j4Wnpw>WFT*DIv_GIGBzzSF)cDUATc#MGBi3fF(6e`Lm*;#AZ=lEX>
TBRX>@2Hb7N_6c_1JlARr(hARr(hARr(hARr(hARr(hARr(hARr(hb^-tZ0000000Bu&4*&oFTmS$7c%0*7U|^U5#B4y
!0mOm~5Won;JV5N2oSd4IT9jClnV$y{XJPPl_74Wha{_TmW^QUpVp2{jR39G@dmx#|3l(RD^4XwfGeX5dd<h8iE)$X*2
!r?l-ZKmx4*&oFQvd(}c%0*7U|{F~Vm2V=0AfJ~2w-GjW=JV50@5rDzRv!^j6g9?ATG(wO)W`G%1MQ);{#$3B>lWlaaJ
gw4Qv(!GeG$g5awMbBspdv2Jrz8jtGYj0000=0001Zoa19)U}ykhHX!BzVnGH7U<AStFwMf?>+B!Q2xPMYaY<rQPAZV*
17Z&(eY{Y8tWZ81ST6)KK=~37=3OQvIaVkJ0N}?3*be{z05bpp0C=3^V_;xN0Ae;E=77>5zzXFvLd6(?umVVP0<i%DI{
07@WjH`64k#@Er9~V7mqi1m4*&oFOaK4?c%0*7U|?tfVm2V=0AfJ~2w-GjVJOc?%>&WC&i=uSQ2CU^lGKvS+*Cdw+XG1
-FH|2Zl+Ok>1A-Z#d<h8iE)$X*JCp_h+;0ef4*&oFP5=M^c%0*7U|?tfVm2V=0AfJ~2w-GjVaQ9&O$E`u&i=uSP&LIRM
VWc&3=Digwg-|vUZ_4+D4z{%1_U!e`4SN3T_z+skXjZX1^}CR2f7ac006@T004NL?O8i-8%GeHBTo|PSQKL*0g)ncV<V
-C6zW7+wBZzz4L@YNvd-c~UVwKz+#Th}l@k96B~4PQOc?|D1Md6>45Un{(v|Ifl5@j5%J&Fl!5m;UJ99HTvwOR<A5Sd+
SiK6c$a#aeCMa6avL%G8nscgY8LS^SMYqM<$(4zJEydq7rMKlXOWSO2+`4PVIY#4rsqL*Xx23I+mwCIv2JVB<2?95K{8
;-xMgEg`O74(6q<uYm-fQ)weNF3Z&fB~l@%EOtE;s1#hyU@mT31cjIsO6ko!Ei+IsD|sqVLAcb3y!xohJhqJT@4x2>PS
YiP_MHC=Qvw2m4OwJDwYX9}b`Kzg&)hceS$5ya<AD7(}3k$)*J&FA}*y<R+2ZDP!XISts%$k(Y>kX-2L!)W>UX5j!&$w
l{rS=S0U9I=U8hov%%FplxYfVYfu=O&_mgo#c(z$VR!>V6r|odS>!mLgR?>FX+B_M_=f^&|TDhp<C8{p=;^B(5>ixi{!
V0@@u0U%-O4wT8Qt!<lLD(xqxJR?!<goW$$qN-9JBHd;f>x(EUa6e>Fe+RXzXih2$;mXX4l-jv*7r?DaB!K{H<+{7TC&
`5##;DDkttB~LvjUJs^~{>Zx{ss&YUi{g<WUP<mT>b^0G;-Pn2R+TYvUnVL{;^Dp<M!Z<vb@tu<jd18mOON>*LoeWEjG
J#O3t;}P*0BML4>qGcZs~-fb3o#VJbR+5C1@16+j^$ALbf+n_Vk)el>I3US|zINxzTRO0#R_IvGTsp;$(PHrLXV1enQP
HH->)9{1Kl|GF$on#eI-<|Cn=+@1Gqgat<)PU01x(Rs53X9nHV((m3WEX2rQk;^5i}C{J@1E};4Ropb(O$UbML*5Pv|W
Vv@^#|ui1V>Wk$#yQHF|ExMe&wHEq9v1X_r2W<)d%sY>Cg6J2>6Y^c>3<XXFB5;dkA&P&-8VJ#%=BqKA5$+Weyh^|EY`
E|{bc2v_t#p!#v7`CD9ZiF4SQ2J(7j~!cf*(^&Px^dD_uA0*F=72_r9m!SF<+TzovU-{Jw|mdPLXhQ?xJop7X}JJtL06
v^dUXp!7pm@t)>er=HKWIvweJ{%Xu|;OC434`DWrpmnMI{yot+P(mT$DfjR3DS70@GdAG;Zc8jyCH~sUxo&ySrvqj0fp
*Dz|75)?9A&<B%yHBlN6m5697k1wqXJ~VLhLOvj;LE*!0WBZd_%QP;SM~3T^+Y$W#?(Z<Qt{Q6W33=9{78!S&t5y@9)0
}dbzIntEqaNZ@lz-w~G31zD<kqUPHe1$$Kxx1^xC4`Wc*DypA+V-W$q4@A)WO_g*jLtGnN5`A^HhU<sMVc$WFjz+hq57
hpU2C>701N`>^2QgOYcRB$gT72&HmnWLrOpEx%%P2rQ6Cicl#0LZ$Lah&O20_Mr|&w=r}O~L=OxYy1v?yCkz7sX9w^DY
`UZ@sDd_Zz+^+FZIbd{*iA^G_Am{NMIFGv;CLay*ao^8d`I$S(~KE+IdGbJmb->PeQ2aiEEJJOc+(-1IT^3lihxuYYs@
+5QD_ZYs^+|M~L&0Ams^TL
""".replace("\n", "")
)


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "log.mat"
    path.write_bytes(FILE)
    return path


def test_timetables_have_clocks_of_their_own(log):
    record = read_record(log, ["a=Acceleration.X:m/s^2", "b=dur.a:m"])
    a, b = record.channels["a"], record.channels["b"]
    np.testing.assert_array_equal(a.values, 1.5 * np.arange(6))
    assert (a.rate_hz, b.rate_hz) == pytest.approx((100.0, 50.0))
    assert a.clock.source == "column 'Acceleration.Timestamp'"
    assert b.clock.source == "column 'dur.Time'"


def test_tables_dates_and_what_is_left_out(log):
    table = open_table(log)
    found = table.load(["T.t", "T.g", "when", "x"])
    np.testing.assert_allclose(found["T.t"], [0.0, 0.1, 0.2])
    np.testing.assert_array_equal(found["when"], START + 10_000_000 * np.arange(6))
    assert table.notes == (
        "T.s is not a number, and left out",
        "'name' is of the class 'string', not read; save its numbers as plain arrays",
    )
    assert read_record(log, ["g=T.g:m"]).channels["g"].rate_hz == pytest.approx(10.0)


def test_lines_for_what_is_not_read():
    assert "timetable2table(TT, 'ConvertRowTimes', false)" in not_read("TT", "timetable")
    assert "save('log.mat', '-struct', 'S')" in not_read("T", "table")


def regular(rows, rate, step_ms):
    """A timetable by its rate or its step, with two columns of three, as MATLAB lays it out."""
    magic = np.uint32(0xDD000000)

    def reference(number, kind):
        return np.array([[magic], [2], [1], [1], [number], [kind]], np.uint32)

    def struct(**fields):
        return mat.Structs((1, 1), {name: [value] for name, value in fields.items()})

    names = ["timetable", "datetime", "duration", "any", "data", "millis"]
    times = struct(
        origin=reference(2, 2),
        specifiedAsRate=np.array([[rate is not None]]),
        stepSize=reference(3, 3),
        sampleRate=np.array([[rate or 0.0]]),
    )
    table = struct(
        data=mat.Cells((1, 1), [np.ones((rows, 3))]),
        varNames=mat.Cells((1, 1), ["v"]),
        varUnits=mat.Cells((1, 1), ["m/s"]),
        dimNames=mat.Cells((1, 2), ["Time", "Variables"]),
        numRows=np.array([[float(rows)]]),
        rowTimes=times,
    )
    origin = np.array([[START / 1e6 + 0.0j]])
    cells = [None, None, table, origin, np.array([[step_ms]])]
    classes = np.array([0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0], np.uint32)
    objects = np.array([[0] * 6] + [[k, 0, 0, 0, k, k] for k in (1, 2, 3)], np.uint32).ravel()
    plain = np.array([0, 0, 1, 4, 1, 0, 1, 5, 1, 1, 1, 6, 1, 2], np.uint32)
    return Objects(names, classes, objects, plain[:0], plain, cells), reference(1, 1)


@pytest.mark.parametrize(("rate", "step_ms"), [(8.0, 0.0), (None, 125.0)])
def test_regular_timetables(rate, step_ms):
    found = columns_of(*regular(5, rate, step_ms))
    assert found is not None
    assert (found.time, found.units) == ("Time", {"Time": "ns", "v": "m/s"})
    np.testing.assert_array_equal(found.columns["Time"], START + 125_000_000 * np.arange(5))
    assert found.columns["v"].shape == (5, 3)


def test_impossible_timetables():
    objects, reference = regular(5, 8.0, 0.0)
    objects.cells[2].fields["numRows"] = [np.array([[1e12]])]
    with pytest.raises(ValueError, match="do not have its number of rows"):
        columns_of(objects, reference)


@pytest.mark.parametrize("keep", [200, 700, 1200, 1800])
def test_damaged_files(tmp_path, keep):
    path = tmp_path / "log.mat"
    path.write_bytes(FILE[:keep])
    assert "the MAT file is damaged" in refusal(path, ["a=Acceleration.X"])
