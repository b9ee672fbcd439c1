"""Waiting for jobs, and hearing of them on the way."""

from __future__ import annotations

import time

import pytest

from photonfarm import Farm, FarmError, JobView
from photonfarm.event_stream import ServerEvent, parse

from .lossy_proxy import LossyProxy
from .scenes import BOX, ENDLESS, SMALL


def test_progress_is_told_until_the_end(farm: Farm) -> None:
    heard: list[JobView] = []
    job = farm.submit(BOX, stop={"seconds": 2.5}, **SMALL)
    last = job.wait(progress=heard.append)
    assert last == heard[-1]
    assert last.state == "done"
    passes = [view.passes_done for view in heard]
    assert len(passes) >= 3
    assert passes == sorted(passes)
    assert 0 < passes[1] < passes[-1]


def test_a_line_of_progress_is_printed(farm: Farm, capsys: pytest.CaptureFixture[str]) -> None:
    job = farm.submit(BOX, stop={"passes": 3}, **SMALL)
    job.wait(progress=True)
    assert f"{job.id} done: 3 of 3 passes" in capsys.readouterr().err
    job.wait()
    assert capsys.readouterr().err == ""


def test_waiting_ends_in_time(farm: Farm) -> None:
    job = farm.submit(BOX, **ENDLESS)
    start = time.monotonic()
    with pytest.raises(FarmError) as error:
        job.wait(timeout=1.3)
    assert error.value.kind == "too-late"
    assert 1.3 <= time.monotonic() - start < 3
    assert job.status(wait=0).state == "running"
    job.delete()


def test_a_wait_that_no_coordinator_keeps_is_refused(farm: Farm) -> None:
    with pytest.raises(FarmError, match="give 0 to 60"):
        farm.submit(BOX, wait=61)
    with pytest.raises(FarmError, match="give 0 to 60"):
        farm.submit(BOX, stop={"passes": 1}, **SMALL).status(wait=-1)


def test_events_come_until_the_end(farm: Farm) -> None:
    views = list(farm.submit(BOX, stop={"seconds": 1}, **SMALL).events())
    assert len(views) > 2
    assert [view.state == "done" for view in views] == [False] * (len(views) - 1) + [True]


def test_events_of_a_job_go_on_after_the_stream_broke(farm: Farm) -> None:
    job = farm.submit(BOX, stop={"seconds": 3}, **SMALL)
    with LossyProxy(farm.connection.address) as proxy, Farm(proxy.address, token="") as behind:
        views = []
        for view in behind.job(job.id).events():
            views.append(view)
            if len(views) in (2, 4):
                proxy.break_all()
        assert proxy.connections >= 3
    passes = [view.passes_done for view in views]
    assert passes == sorted(passes)
    assert len(passes) > 4
    assert (views[-1].state, views[-1].passes_done) == ("done", job.status().passes_done)


def test_events_of_a_farm_are_not_told_twice_after_the_stream_broke(farm: Farm) -> None:
    ended = farm.submit(BOX, stop={"passes": 1}, wait=60, **SMALL)
    jobs = {job.id for job in farm.jobs()}
    running = farm.submit(BOX, stop={"seconds": 2}, **SMALL)
    with LossyProxy(farm.connection.address) as proxy, Farm(proxy.address, token="") as behind:
        heard = []
        for event in behind.events():
            heard.append(event)
            # An id ends a batch, so all before it was heard.
            if event.id is not None and proxy.connections == 1:
                proxy.break_all()
            if event.job_id == running.id and event.status is not None and event.status.state == "done":
                break
        assert proxy.connections == 2
    assert {event.job_id for event in heard} == jobs | {running.id}
    assert [event.job_id for event in heard].count(ended.id) == 1
    assert [event.job_id for event in heard].count(running.id) > 1
    assert all(event.kind == "status" for event in heard)


def test_events_of_a_farm_begin_where_they_were_left(farm: Farm) -> None:
    first = farm.submit(BOX, stop={"passes": 1}, wait=60, **SMALL)
    events = farm.events()
    left_at = next(event.id for event in events if event.id is not None)
    second = farm.submit(BOX, stop={"passes": 1}, wait=60, **SMALL)
    first.delete()
    heard = []
    for event in farm.events(last_event_id=left_at):
        heard.append((event.kind, event.job_id))
        if len(heard) == 2:
            break
    assert set(heard) == {("status", second.id), ("deleted", first.id)}


def test_numbers_of_another_run_are_forgotten(farm: Farm) -> None:
    assert next(farm.events(last_event_id="1-1")).kind == "reset"


def test_events_are_read_from_any_pieces_of_bytes() -> None:
    text = ": comment\r\n\r\nevent: status\r\ndata: {\r\ndata: }\r\nid: 7\r\n\r\nevent:empty\n\ndata:ß\n\ndata: broken off".encode()
    expected = [ServerEvent("status", "{\n}", "7"), ServerEvent("message", "ß", None)]
    for size in (1, 2, 3, 7, len(text)):
        assert list(parse(text[at : at + size] for at in range(0, len(text), size))) == expected
