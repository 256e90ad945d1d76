"""The closed loop against theory: the same discrete system built by scipy, and the classic formulas (chapter 2.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import signal  # type: ignore[import-untyped]
from scipy.optimize import brentq  # type: ignore[import-untyped]

from motion_kernel import Machine, Mcu, ModeReg

FULL_SCALE = 32767.0
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Loop:
    """One servo axis with a velocity-controlled drive."""

    kp: float
    ki: float = 0.0
    kd: float = 0.0
    kpl: float = 0.0
    kfcv: float = 0.0
    lag_s: float = 0.003
    counts_per_mm: float = 10_000.0
    full_speed: float = 250.0
    mpe: float = 1.0

    def machine(self) -> Machine:
        """The machine file of the axis, its program address X."""
        return Machine.parse(
            f"""
            [[axis]]
            name = "X"
            counts_per_unit = {self.counts_per_mm!r}
            rapid = 200.0
            acceleration = 1000.0
            mpe = {self.mpe!r}
            pidf = {{ kp = {self.kp!r}, ki = {self.ki!r}, kd = {self.kd!r}, kpl = {self.kpl!r}, kfcv = {self.kfcv!r} }}
            plant = {{ lag_s = {self.lag_s!r}, full_speed = {self.full_speed!r} }}
            """
        )

    @property
    def velocity_gain(self) -> float:
        """KV: speed per position error, 1/s."""
        return self.kp * self.counts_per_mm * self.full_speed / FULL_SCALE


def simulated(loop: Loop, set_points: Floats, sample_time_s: float) -> Floats:
    """Motor positions by scipy: filter by the bilinear transform, drive and integrator by zero-order hold, the encoder
    in whole counts. Nothing here is taken from the kernel."""
    lag = (1.0 - loop.kpl) * sample_time_s / 2.0
    numerator, denominator = [loop.kd, loop.kp, loop.ki], [lag, 1.0, 0.0]
    b, a = signal.bilinear(numerator, denominator, 1.0 / sample_time_s)
    memory = np.zeros(2)
    gain = loop.full_speed / FULL_SCALE
    drive = (np.array([[0.0, 1.0], [0.0, -1.0 / loop.lag_s]]), np.array([[0.0], [gain / loop.lag_s]]))
    step, push, *_ = signal.cont2discrete((*drive, np.eye(2), np.zeros((2, 1))), sample_time_s)
    state, command, positions = np.zeros(2), 0.0, []
    for set_point in set_points:
        state = step @ state + push[:, 0] * command
        error = set_point * loop.counts_per_mm - np.round(state[0] * loop.counts_per_mm)
        out, memory = signal.lfilter(b, a, [error], zi=memory)
        command = float(out[0])
        assert abs(command) < FULL_SCALE, "the linear theory needs a command that is not clamped"
        positions.append(state[0])
    return np.array(positions)


def driven(loop: Loop, set_points: Floats) -> tuple[Floats, Floats]:
    """Load positions and encoder positions of the kernel for the same set points."""
    mcu = Mcu(loop.machine())
    mcu.cl(["X"])
    loads, encoder = [], []
    for set_point in set_points:
        mcu.wrdp("X", float(set_point))
        mcu.advance(1)
        loads.append(float(mcu.trace.load[0, 0]))
        encoder.append(float(mcu.trace.rp[0, 0]))
    return np.array(loads), np.array(encoder)


SAMPLE_TIME_S = 1.28e-3
STEP = np.full(300, 0.1)
RAMP = np.arange(300) * 0.03
SINE = 0.5 * np.sin(np.arange(400) * 0.02)

loops = st.builds(
    Loop,
    kp=st.floats(0.1, 1.5),
    ki=st.floats(0.0, 8.0),
    kd=st.floats(0.0, 1e-3),
    kpl=st.floats(0.0, 0.95),
    lag_s=st.floats(5e-4, 8e-3),
    counts_per_mm=st.sampled_from([500.0, 2_000.0, 10_000.0]),
)


@pytest.mark.parametrize("set_points", [STEP, RAMP, SINE], ids=["step", "ramp", "sine"])
@settings(max_examples=12, deadline=None)
@given(loop=loops)
def test_the_loop_equals_the_same_system_in_scipy(set_points: Floats, loop: Loop) -> None:
    scale = min(1.0, 10_000.0 / (loop.kp + 2.0 * loop.kd / SAMPLE_TIME_S) / loop.counts_per_mm / 0.1)
    want = simulated(loop, set_points * scale, SAMPLE_TIME_S)
    got, encoder = driven(loop, set_points * scale)
    assert np.abs(got - want).max() < 1e-9
    assert np.abs(encoder * loop.counts_per_mm - np.round(want * loop.counts_per_mm)).max() < 1e-6


def at_constant_speed(loop: Loop, speed: float) -> Floats:
    """Following errors at constant speed, mm."""
    mcu = Mcu(loop.machine())
    mcu.cl(["X"])
    mcu.smla({"X": 200.0}, ac=500.0, vl=speed)
    mcu.ssms(["X"])
    ramp = round(speed / 500.0 / SAMPLE_TIME_S)
    mcu.advance(ramp + 500)
    mcu.advance(200)
    return np.asarray(mcu.trace.dp[:, 0] - mcu.trace.rp[:, 0])


@settings(max_examples=12, deadline=None)
@given(kp=st.floats(0.3, 1.2), speed=st.floats(10.0, 100.0))
def test_a_proportional_loop_follows_at_v_over_kv(kp: float, speed: float) -> None:
    loop = Loop(kp=kp)
    errors = at_constant_speed(loop, speed)
    assert errors.mean() == pytest.approx(speed / loop.velocity_gain, rel=0.01)


@settings(max_examples=12, deadline=None)
@given(kp=st.floats(0.3, 1.2), speed=st.floats(10.0, 100.0))
def test_full_feed_forward_follows_within_two_counts(kp: float, speed: float) -> None:
    loop = Loop(kp=kp, kfcv=FULL_SCALE / 250.0 / 10_000.0)
    errors = at_constant_speed(loop, speed) * loop.counts_per_mm
    # the set point is that of the end of the sample in which the drive gets its command
    assert np.abs(errors).max() < 2.0


def poles(loop: Loop) -> Floats:
    """Magnitudes of the poles of the closed loop without quantisation."""
    lag = (1.0 - loop.kpl) * SAMPLE_TIME_S / 2.0
    b, a = signal.bilinear([loop.kd, loop.kp, loop.ki], [lag, 1.0, 0.0], 1.0 / SAMPLE_TIME_S)
    gain = loop.full_speed / FULL_SCALE * loop.counts_per_mm
    bz, az, _ = signal.cont2discrete(([gain], [loop.lag_s, 1.0, 0.0]), SAMPLE_TIME_S)
    return np.asarray(np.abs(np.roots(np.polyadd(np.polymul(a, az), np.polymul(b, bz[0])))))


def critical_gain() -> float:
    """The KP at which the loop begins to swing, by its poles."""
    return float(brentq(lambda kp: poles(Loop(kp=kp)).max() - 1.0 - 1e-9, 0.6, 60.0))


@pytest.mark.parametrize("share", [0.3, 0.8, 1.25, 3.0])
def test_a_loop_diverges_where_its_poles_say_so_and_mpe_catches_it(share: float) -> None:
    loop = Loop(kp=critical_gain() * share, mpe=0.2)
    mcu = Mcu(loop.machine())
    mcu.cl(["X"])
    mcu.wrdp("X", 0.01)
    mcu.advance(4000)
    swing = np.abs(mcu.trace.dp[-500:, 0] - mcu.trace.rp[-500:, 0]).max()
    assert mcu.rdaxst("X").mpe == (share > 1.0), swing
    assert swing < 1e-3 if share < 1.0 else swing > 0.2


def test_simulation_mode_follows_without_a_drive() -> None:
    mcu = Mcu(Loop(kp=0.6).machine())
    mcu.wrmodereg(ModeReg.of("SimulationMode"))
    mcu.cl(["X"])
    mcu.smla({"X": 20.0}, ac=500.0, vl=50.0)
    mcu.ssms(["X"])
    mcu.advance(600)
    assert np.abs(mcu.trace.dp[:-1, 0] - mcu.trace.rp[1:, 0]).max() <= 0.5e-4 + 1e-12
    assert mcu.rdmcp("X") == 0
