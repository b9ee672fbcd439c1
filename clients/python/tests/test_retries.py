"""What is sent again, and does nothing twice."""

from __future__ import annotations

import socket
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from photonfarm import Farm, FarmError, LocalFarm

from .lossy_proxy import LossyProxy
from .scenes import BOX, SKY, SMALL


def test_a_submission_whose_answer_is_lost_makes_one_job(farm: Farm) -> None:
    before = len(farm.jobs())
    with LossyProxy(farm.connection.address) as proxy, Farm(proxy.address, token="") as behind:
        behind.workers()
        proxy.answers_to_lose = 2
        job = behind.submit(SKY, stop={"passes": 1})
        assert proxy.answers_to_lose == 0
    assert len(farm.jobs()) == before + 1
    assert farm.jobs()[-1].id == job.id


def test_what_would_do_something_twice_is_not_sent_again(farm: Farm) -> None:
    job = farm.submit(SKY, stop={"passes": 1}, wait=60)
    with LossyProxy(farm.connection.address) as proxy, Farm(proxy.address, token="") as behind:
        other = behind.job(job.id)
        proxy.answers_to_lose = 1
        with pytest.raises(FarmError) as error:
            other.extend({"passes": 2})
    assert error.value.kind == "unreachable"
    assert job.wait().passes_done == 2


def test_the_same_key_gives_the_same_job(farm: Farm) -> None:
    first = farm.submit(SKY, stop={"passes": 1}, idempotency_key="shot-7-frame-12")
    assert farm.submit(SKY, stop={"passes": 1}, idempotency_key="shot-7-frame-12").id == first.id
    with pytest.raises(FarmError) as error:
        farm.submit(SKY, stop={"passes": 2}, idempotency_key="shot-7-frame-12")
    assert error.value.status == 422
    clone = first.clone(seed=3, idempotency_key="again")
    assert first.clone(seed=3, idempotency_key="again").id == clone.id
    assert farm.submit(SKY, stop={"passes": 1}).id != first.id


def test_waiting_outlasts_a_coordinator_that_starts_again(program: Path, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        listen = f"127.0.0.1:{free.getsockname()[1]}"
    local = LocalFarm(workers=1, threads=1, program=program, data=tmp_path, listen=listen)
    with local as farm:
        job = farm.submit(BOX, stop={"passes": 200}, **SMALL)
        next(view for view in job.events() if view.passes_done > 0)
        states: list[str] = []
        waiting = threading.Thread(target=lambda: states.append(job.wait().state))
        waiting.start()
        local.stop()
        assert states == []
        time.sleep(1)
        again = local.start()
        waiting.join(60)
        assert states == ["done"]
        quiet = again.submit(BOX, stop={"passes": 200}, wait=60, **SMALL)
        assert np.array_equal(job.picture(), quiet.picture())


def test_a_busy_farm_is_asked_again_when_it_says_so(program: Path, tmp_path: Path) -> None:
    admin_token = "0" * 32
    (tmp_path / "token").write_text(admin_token)
    options = ["--admin-token-file", str(tmp_path / "token"), "--user-jobs", "1"]
    with LocalFarm(workers=1, threads=1, program=program, token=admin_token, options=options) as admin:
        token = admin.call("POST", "/v1/users", {"name": "anna", "role": "artist"})["token"]["secret"]
        with Farm(admin.connection.address, token) as anna, Farm(admin.connection.address, token, patience=0) as hasty:
            first = anna.submit(BOX, stop={"seconds": 1.5}, **SMALL)
            with pytest.raises(FarmError) as error:
                hasty.submit(SKY, stop={"passes": 1})
            assert (error.value.status, error.value.kind) == (429, "busy")
            assert error.value.retry_after is not None
            assert anna.submit(SKY, stop={"passes": 1}, wait=60).known.state == "done"
            assert first.status().state == "done"


def test_of_several_addresses_the_one_that_answers_is_used_without_a_pause(farm: Farm, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("photonfarm.connection.PAUSE", 30)
    with Farm(f"http://127.0.0.1:9,{farm.connection.address}", token="") as several:
        start = time.monotonic()
        assert several.workers()
        assert time.monotonic() - start < 15
        assert several.connection.address == farm.connection.address
