"""A client of photonfarm, the distributed global-illumination renderer.

from photonfarm import Farm

job = Farm("http://127.0.0.1:8080").submit("scene.xml", stop={"passes": 64})
job.wait(progress=True)
array = job.picture()
"""

from .errors import FarmError
from .farm import Farm, FarmEvent, JobOptions
from .frame_sequence import FrameSequence
from .generated.models import JobView, StopRule
from .job import Job
from .local_farm import LocalFarm

__all__ = ["Farm", "FarmError", "FarmEvent", "FrameSequence", "Job", "JobOptions", "JobView", "LocalFarm", "StopRule"]
