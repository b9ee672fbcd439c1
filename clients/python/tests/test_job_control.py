"""Jobs that are changed while they are there."""

from __future__ import annotations

import time

import numpy as np
import pytest

from photonfarm import Farm, FarmError

from .scenes import BOX, ENDLESS, SMALL


def test_a_paused_job_stands_still_and_goes_on(farm: Farm) -> None:
    job = farm.submit(BOX, **ENDLESS)
    try:
        assert job.pause().state == "paused"
        # What is being traced is still merged.
        time.sleep(1)
        before = job.status().passes_done
        time.sleep(0.5)
        assert job.status().passes_done == before
        with pytest.raises(FarmError) as error:
            job.pause()
        assert (error.value.status, error.value.kind) == (409, "conflict")
        assert job.resume().state in ("queued", "running")
        assert any(view.passes_done > before for view in job.events())
    finally:
        job.delete()


def test_an_extended_job_gets_the_bits_of_the_longer_one(farm: Farm) -> None:
    extended = farm.submit(BOX, stop={"passes": 8}, wait=60, **SMALL)
    short = extended.picture()
    extended.extend({"passes": 24})
    assert extended.wait().passes_done == 24
    longer = farm.submit(BOX, stop={"passes": 24}, wait=60, **SMALL)
    assert longer.id != extended.id
    assert np.array_equal(extended.picture(), longer.picture())
    assert not np.array_equal(extended.picture(), short)
    with pytest.raises(FarmError) as error:
        extended.extend({"passes": 24})
    assert error.value.status == 422


def test_a_cancelled_job_keeps_its_picture(farm: Farm) -> None:
    job = farm.submit(BOX, **ENDLESS)
    next(view for view in job.events() if view.passes_done > 0)
    assert job.cancel().state == "cancelled"
    assert job.picture().shape == (32, 32, 3)
    with pytest.raises(FarmError) as error:
        job.wait()
    assert error.value.kind == "job-cancelled"


def test_a_deleted_job_is_gone(farm: Farm) -> None:
    job = farm.submit(BOX, **ENDLESS)
    job.delete()
    with pytest.raises(FarmError) as error:
        job.status()
    assert (error.value.kind, error.value.status) == ("unknown-job", 404)
    assert job.id not in {other.id for other in farm.jobs()}


def test_a_clone_differs_as_asked(farm: Farm) -> None:
    job = farm.submit(BOX, stop={"passes": 2}, wait=60, **SMALL)
    clone = job.clone(seed=1, name="another", tags=["copy"], priority=7, stop={"passes": 3}, parameters={"photons_per_pass": 2048})
    view = clone.wait()
    assert (view.tags, view.priority) == (["copy"], 7)
    assert (view.seed, view.name, view.passes_done, view.parameters["photons_per_pass"]) == (1, "another", 3, 2048)
    assert view.scene == job.known.scene
    assert not np.array_equal(clone.picture(), job.picture())
    assert job.clone(method="path", stop={"passes": 1}).known.method == "path"


def test_name_tags_and_priority_change(farm: Farm) -> None:
    job = farm.submit(BOX, stop={"passes": 1}, wait=60, tags=["old"], **SMALL)
    view = job.change(name="shot 7", tags=["new"], priority=7)
    assert (view.name, view.tags, view.priority) == ("shot 7", ["new"], 7)
    assert job.change(priority=8).name == "shot 7"


def test_jobs_are_found_by_what_they_are(farm: Farm) -> None:
    job = farm.submit(BOX, stop={"passes": 1}, wait=60, name="to be found", tags=["findable"], **SMALL)
    assert [found.id for found in farm.jobs(tag="findable")] == [job.id]
    assert [found.id for found in farm.jobs(name="to be found", state="done")] == [job.id]
    assert farm.jobs(name="to be found", state="failed") == []
    assert farm.job(job.id).known == job.status()
    assert any(line.job == job.id for line in farm.journal(job=job.id))


def test_what_a_farm_has(farm: Farm) -> None:
    assert [worker.threads for worker in farm.workers()] == [1]
    assert {"sppm", "path"} <= {method.name for method in farm.methods()}
    scene = farm.upload(BOX)
    assert scene.hash in {known.hash for known in farm.scenes()}
    assert farm.limits().pixels > 0
    assert farm.call("GET", "/healthz")["status"] == "ok"


def test_a_scene_that_no_job_needs_is_deleted(farm: Farm) -> None:
    scene = farm.upload(BOX.parent.parent / "pool")
    farm.delete_scene(scene.hash)
    assert scene.hash not in {known.hash for known in farm.scenes()}
