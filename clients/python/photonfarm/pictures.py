"""EXR pictures as numpy arrays."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import OpenEXR
from numpy.typing import NDArray

# In this order channels stand beside each other in an array; a layer of one channel has no such axis.
CHANNEL_ORDER = "RGBXYZ"
# Layers whose channels have names of their own, as compositors know them.
MATTES = {"crypto_object": "CryptoObject", "crypto_material": "CryptoMaterial"}

Channels = dict[str, NDArray[np.float32]]


def read_channels(exr: bytes) -> Channels:
    """All channels of an EXR file by name, each (height, width)."""
    # OpenEXR reads files only.
    with tempfile.TemporaryDirectory(prefix="photonfarm-") as folder:
        path = Path(folder, "picture.exr")
        path.write_bytes(exr)
        with OpenEXR.File(str(path), separate_channels=True) as file:
            return {name: np.array(channel.pixels, dtype=np.float32) for name, channel in file.channels().items()}


def picture(channels: Channels) -> NDArray[np.float32]:
    """The picture itself: (height, width, 3), linear."""
    return np.stack([channels[name] for name in "RGB"], axis=-1)


def layer(channels: Channels, name: str) -> NDArray[np.float32]:
    """One layer: (height, width), (height, width, 3) for one of three channels, or (height, width, 6, 2) for pairs of id and coverage."""
    if name in MATTES:
        ranks = [channels[f"{MATTES[name]}{part:02}.{letter}"] for part in range(3) for letter in "RGBA"]
        return np.stack(ranks, axis=-1).reshape(*ranks[0].shape, 6, 2)
    ends = sorted((channel.split(".", 1)[1] for channel in channels if channel.startswith(name + ".")), key=CHANNEL_ORDER.index)
    planes = [channels[f"{name}.{end}"] for end in ends]
    return planes[0] if len(planes) == 1 else np.stack(planes, axis=-1)


def light_groups(channels: Channels) -> Channels:
    """The light of each light group by `light_group.NAME`, each (height, width, 3)."""
    groups = [channel.removesuffix(".R") for channel in channels if channel.startswith("light_group.") and channel.endswith(".R")]
    return {group: np.stack([channels[f"{group}.{letter}"] for letter in "RGB"], axis=-1) for group in groups}


def layers(channels: Channels, names: Iterable[str]) -> Channels:
    """Several layers by name; `light_groups` stands for as many as there are groups."""
    found: Channels = {}
    for name in names:
        found |= light_groups(channels) if name == "light_groups" else {name: layer(channels, name)}
    return found
