"""Times the reslice engine beside vtkImageReslice and SimpleITK: the same volume and planes, one thread, taking turns.

    cargo xtask bench peers [-- --rounds N] [-- --size PIXELS]

makes a Python environment with `requirements.txt` in `target/venv-peers` and runs this script in it; by hand:

    python slice-view-proc/benches/peers/reslice.py [--rounds N] [--size PIXELS] [--engine COMMAND]

Our engine is the program of `benches/reslice.rs` with `--serve`; it writes the volume (512 x 512 x 400 voxels of 16 bits) to
a temporary folder, from which the others read it. In every round each contestant draws one plane of each set, each
another one, so that none finds its lines in the caches. Medians over the rounds; CPU time of all threads of the process
that draws. The ratio is to ours with the same filter. Errors are distances from our f64 reference with the same filter,
at pixels whose neighbours all lie inside the volume; the reference of nearest and linear is held against NumPy first.
VTK and SimpleITK have the volume in an array of NumPy's, which asks for huge pages; ours has pages of 4 KiB.
"""

import argparse
import os
import shlex
import statistics
import sys
import tempfile
from collections import defaultdict

import numpy as np
import SimpleITK as sitk
import vtk

# No folder of compiled files in the source tree.
sys.dont_write_bytecode = True
from contestants import Engine, Ours, Plane, itk_contestants, vtk_contestants

FILTERS = ["nearest", "linear", "cubic", "b-spline", "sinc-3", "sinc-5"]
ENGINE = "cargo bench --quiet --package slice-view-proc --bench reslice --"
PIXEL_MM = 0.5
# Slow contestants, tens of seconds an image, draw one plane of one set.
SLOW_SET = "poses by chance"
# The sinc filters take a large part of a second, and vary little.
SINC_ROUNDS = 3
# Voxels that the widest filter needs around a pixel.
MARGIN = 6


def centred(centre, right, down, size):
    half = (size - 1) / 2 * PIXEL_MM
    return Plane(centre - right * half - down * half, right, down, PIXEL_MM, size)


def unit(v):
    return np.asarray(v) / np.linalg.norm(v)


def plane_sets(volume, count, size):
    """Named sets of planes, each mostly inside."""
    rng = np.random.default_rng(4)
    dims = np.array(volume.voxels.shape[::-1])
    middle = np.array(volume.origin_mm) + (dims - 1) / 2 * np.array(volume.spacing_mm)
    x, y, z = np.eye(3)

    def near():
        return middle + rng.uniform(-40, 40, 3)

    def rigid():
        q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        return centred(near(), q[0], q[1], size)

    def on_path(i):
        into = unit([-0.7, -0.5 + 0.05 * np.sin(0.3 * i), 0.4])
        right = unit(np.cross(z, into))
        return centred(middle + into * (0.4 * i), right, np.cross(into, right), size)

    return {
        "axial": [centred(near(), x, y, size) for _ in range(count)],
        "frontal": [centred(near(), x, -z, size) for _ in range(count)],
        "sagittal": [centred(near(), y, -z, size) for _ in range(count)],
        "poses by chance": [rigid() for _ in range(count)],
        "coherent path": [on_path(i) for i in range(count)],
    }


def indices(volume, plane):
    """Continuous voxel indices (x, y, z) of every pixel."""
    across = np.arange(plane.size) * plane.pixel_mm
    points = plane.origin + across[None, :, None] * plane.right + across[:, None, None] * plane.down
    return (points - np.array(volume.origin_mm)) / np.array(volume.spacing_mm)


def interior(volume, plane):
    dims = np.array(volume.voxels.shape[::-1])
    index = indices(volume, plane)
    return ((index >= MARGIN) & (index <= dims - 1 - MARGIN)).all(axis=2)


def by_numpy(volume, plane, filter):
    """The slice in f64 at interior pixels, by other code than ours."""
    index = indices(volume, plane)[interior(volume, plane)]
    if filter == "nearest":
        x, y, z = np.floor(index + 0.5).astype(int).T
        return volume.voxels[z, y, x].astype(float)
    low = np.floor(index).astype(int)
    part = index - low
    total = np.zeros(len(index))
    for corner in np.ndindex(2, 2, 2):
        x, y, z = (low + corner).T
        total += np.where(corner, part, 1 - part).prod(axis=1) * volume.voxels[z, y, x]
    return total


def check_reference(engine, plane):
    """The oracle against NumPy. Where an index lies in the middle between two voxels, nearest may take either."""
    inside = interior(engine.volume, plane)
    for filter in ["nearest", "linear"]:
        ours = engine.draw(f"{filter}/reference", plane)[2][inside]
        far = np.abs(ours - by_numpy(engine.volume, plane, filter))
        print(f"f64 reference against NumPy, {filter}: at most {far.max():.1e} HU, {(far > 0.01).sum()} of {far.size} above 0.01")


def error(engine, contestant, plane, truths):
    key = (contestant.filter, id(plane))
    if key not in truths:
        truths[key] = engine.draw(f"{contestant.filter}/reference", plane)[2].astype(float)
    inside = interior(engine.volume, plane)
    far = (contestant.draw(plane)[2] - truths[key])[inside]
    return np.abs(far).max(), np.sqrt((far**2).mean())


def turns(contestant, name, rounds):
    """How often a contestant draws from a set."""
    if contestant.slow:
        return 1 if name == SLOW_SET else 0
    return min(rounds, SINC_ROUNDS) if contestant.filter.startswith("sinc") else rounds


def race(contestants, sets, rounds):
    times = defaultdict(list)
    for turn in range(rounds):
        # The order changes, so that no one always follows the same.
        order = contestants[turn % len(contestants) :] + contestants[: turn % len(contestants)]
        for name, planes in sets.items():
            for place, contestant in enumerate(order):
                if turn >= turns(contestant, name, rounds):
                    continue
                shift = 0 if name == "coherent path" else 3 * place
                times[name, contestant].append(contestant.draw(planes[(turn + shift) % len(planes)])[:2])
    return times


def print_set(name, engine, contestants, sets, times):
    print(f"\n{name}; load {os.getloadavg()[0]:.1f}")
    print(f"{'filter':<10}{'who':<30}{'CPU, ms':>16}{'wall, ms':>10}{'ratio':>8}{'max error':>12}{'RMS, HU':>11}")
    truths = {}
    for filter in FILTERS:
        ours = None
        for contestant in [c for c in contestants if c.filter == filter and times[name, c]]:
            cpu, wall = zip(*times[name, contestant])
            median = statistics.median(cpu)
            ours = ours or median
            worst, rms = error(engine, contestant, sets[name][0], truths)
            shown = f"{median:.2f} ({min(cpu):.2f})"
            print(
                f"{filter:<10}{contestant.name:<30}{shown:>16}{statistics.median(wall):>10.2f}"
                f"{median / ours:>8.1f}{worst:>12.2g}{rms:>11.2g}",
                flush=True,
            )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--engine", default=ENGINE, help="the command that starts ours")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        engine = Engine(shlex.split(options.engine), folder)
        contestants = [Ours(engine, "ours", filter, filter) for filter in FILTERS]
        contestants += [Ours(engine, "ours, portable", filter, f"{filter}/portable") for filter in FILTERS[:4]]
        contestants += vtk_contestants(engine.volume) + itk_contestants(engine.volume)
        sets = plane_sets(engine.volume, options.rounds, options.size)
        print(f"VTK {vtk.vtkVersion.GetVTKVersion()}, SimpleITK {sitk.Version.VersionString()}, NumPy {np.__version__}")
        print(f"{options.size} x {options.size} pixels of {PIXEL_MM} mm, {options.rounds} rounds, median (least)")
        check_reference(engine, sets["poses by chance"][0])
        times = race(contestants, sets, options.rounds)
        for name in sets:
            print_set(name, engine, contestants, sets, times)


if __name__ == "__main__":
    main()
