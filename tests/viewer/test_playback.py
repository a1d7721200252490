import pytest

from lingual.viewer.playback import SPEEDS, Playback


def test_time_follows_the_wall_clock_and_the_speed():
    playback = Playback(duration=2.0, speed=0.25)
    playback.advance(0.4, frontier=2.0)
    assert playback.time == pytest.approx(0.1)


def test_time_never_passes_what_is_simulated():
    playback = Playback(duration=2.0)
    playback.advance(0.5, frontier=0.2)
    assert playback.time == 0.2
    assert playback.waiting
    assert playback.playing
    playback.advance(0.1, frontier=1.0)
    assert playback.time == pytest.approx(0.3)
    assert not playback.waiting


def test_at_the_end_it_loops_or_stops():
    looping, ending = Playback(duration=1.0, time=0.9), Playback(duration=1.0, time=0.9, loop=False)
    for playback in (looping, ending):
        playback.advance(0.2, frontier=1.0)
    assert looping.playing
    assert looping.time == 0.0
    assert not ending.playing
    assert ending.time == 1.0
    ending.toggle()
    assert ending.playing
    assert ending.time == 0.0


def test_a_failed_simulation_ends_playback_where_it_stopped():
    playback = Playback(duration=2.0, time=0.75, loop=False)
    playback.advance(0.2, frontier=0.8, frontier_final=True)
    assert playback.time == 0.8
    assert not playback.playing
    assert not playback.waiting


def test_nothing_simulated_yet():
    playback = Playback(duration=2.0)
    playback.advance(0.1, frontier=0.0)
    assert playback.time == 0.0
    playback.advance(0.1, frontier=0.0, frontier_final=True)
    assert playback.time == 0.0


def test_stepping_pauses_and_moves_by_simulation_frames():
    playback = Playback(duration=1.0, time=0.104, frontier=1.0)
    playback.step(1)
    assert playback.time == pytest.approx(0.11)
    assert not playback.playing
    playback.step(-3)
    assert playback.time == pytest.approx(0.08)
    for _ in range(20):
        playback.step(-1)
    assert playback.time == 0.0


def test_seeking_is_held_within_the_simulated_part():
    playback = Playback(duration=1.0, frontier=0.5)
    playback.seek(0.9)
    assert playback.time == 0.5
    playback.seek(-1.0)
    assert playback.time == 0.0


def test_speeds_run_from_a_twentieth_to_four():
    playback = Playback(duration=1.0)
    playback.faster(-99)
    assert playback.speed == SPEEDS[0] == 0.05
    playback.faster(99)
    assert playback.speed == SPEEDS[-1] == 4.0
