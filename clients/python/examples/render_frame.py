"""One frame of a render manager's job, rendered by a farm: submits a scene, waits, and writes the picture.

    python3 render_frame.py SCENE OUTPUT --passes 256 --key shot-7-frame-12

The same key again, after the render manager ended or lost this program, finds the job that there is and waits for it.
Where the farm is stands in PHOTONFARM_URL and PHOTONFARM_TOKEN_FILE. Exit codes are those of the command line.
"""

import argparse
import sys

from photonfarm import Farm, FarmError

UNREACHABLE = ("unreachable", "not-a-coordinator", "bad-address")
BAD_INPUT = (400, 413, 415, 422)


def exit_code(error: FarmError) -> int:
    """As docs/RENDER-MANAGERS.md lists them."""
    if error.kind in UNREACHABLE:
        return 4
    if error.kind == "bad-file":
        return 5
    return 3 if error.status in BAD_INPUT else 1


def main() -> int:
    parser = argparse.ArgumentParser(description="Renders one frame on a photonfarm.")
    parser.add_argument("scene")
    parser.add_argument("output", help="an .exr or .png file")
    parser.add_argument("--passes", type=int, required=True)
    parser.add_argument("--key", required=True, help="what names this frame for ever, for example job, layer and frame")
    options = parser.parse_args()
    try:
        with Farm() as farm:
            job = farm.submit(options.scene, stop={"passes": options.passes}, name=options.key, idempotency_key=options.key)
            job.wait(progress=True)
            job.save(options.output)
    except FarmError as error:
        print(error, file=sys.stderr)
        return exit_code(error)
    return 0


if __name__ == "__main__":
    sys.exit(main())
