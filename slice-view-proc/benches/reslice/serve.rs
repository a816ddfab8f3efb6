//! Slices on request, for a script that pairs this engine with other software in one run.
//!
//! `reslice --serve FOLDER` writes the volume to `FOLDER/volume.raw` (i16, little-endian, row by row) and says `ready` with
//! dimensions, spacing and the first voxel's centre. Then each line on stdin
//!
//! ```text
//! FILTER[/BACKEND] ox oy oz rx ry rz dx dy dz width height [FILE]
//! ```
//!
//! (centre of the first pixel, step to the right and step down, mm; BACKEND is `vector`, `portable` or `reference`) is
//! answered by `ok CPU_NS WALL_NS` once the image has been drawn, and written to FILE as f32 where one is named; what
//! cannot be done, by `error` and why.

use std::fs::File;
use std::io::{self, BufRead, BufWriter, Write};
use std::path::Path;

use bus::clock::monotonic_ns;
use bus::volume::OwnedVolume;
use geometry::{Point, SlicePlane, Vector};
use scene::{Filter, Sampling};
use slice_view_proc::reslice::{Cpu, Reference, Resampler};

use crate::shared::figures::cpu_ns;
use crate::shared::planes::orthogonal;

/// Answers until stdin ends.
pub(crate) fn serve(volume: &OwnedVolume, folder: &Path) -> io::Result<()> {
    write_volume(volume, &folder.join("volume.raw"))?;
    let all = Filter::ALL.map(Sampling::from);
    let mut back_ends: [(&str, Box<dyn Resampler>); 3] = [
        ("vector", Box::new(Cpu::default())),
        ("portable", Box::new(Cpu::portable())),
        ("reference", Box::new(Reference::default())),
    ];
    for (_, resampler) in &mut back_ends {
        let prepared = resampler.prepare(&volume.view(), &all, &mut || {});
        prepared.map_err(io::Error::other)?;
    }
    let [x, y, z] = (volume.grid.ct_from_voxel() * Point::new(0.0, 0.0, 0.0)).mm();
    let ([nx, ny, nz], [sx, sy, sz]) = (volume.grid.dims(), volume.grid.spacing_mm());
    println!("ready {nx} {ny} {nz} {sx} {sy} {sz} {x} {y} {z}");
    let mut hu = Vec::new();
    for line in io::stdin().lock().lines() {
        match answer(&line?, volume, &mut back_ends, &mut hu) {
            Ok([cpu, wall]) => println!("ok {cpu} {wall}"),
            Err(why) => println!("error {why}"),
        }
    }
    Ok(())
}

fn write_volume(volume: &OwnedVolume, path: &Path) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    let [nx, ny, nz] = volume.grid.dims();
    let view = volume.view();
    for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
        let row: Vec<u8> = (0..nx).flat_map(|x| view.at([x, y, z]).to_le_bytes()).collect();
        file.write_all(&row)?;
    }
    file.flush()
}

/// CPU and wall time of the image, ns.
fn answer(
    line: &str,
    volume: &OwnedVolume,
    back_ends: &mut [(&str, Box<dyn Resampler>); 3],
    hu: &mut Vec<f32>,
) -> Result<[i64; 2], String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [what, numbers @ ..] = &words[..] else {
        return Err("an empty line".to_owned());
    };
    let (filter, back_end) = what.split_once('/').unwrap_or((what, "vector"));
    let filter = Filter::named(filter).ok_or_else(|| format!("no filter {filter:?}"))?;
    let found = back_ends.iter_mut().find(|(name, _)| *name == back_end);
    let (_, resampler) = found.ok_or_else(|| format!("no back end {back_end:?}"))?;
    let (plane, file) = asked(numbers)?;
    let [width, height] = plane.size();
    hu.resize((width * height) as usize, 0.0);
    let began = [cpu_ns(), monotonic_ns()];
    let drawn = resampler.reslice(&volume.view(), &plane, &filter.into(), hu);
    let took = [cpu_ns() - began[0], monotonic_ns() - began[1]];
    drawn.map_err(|error| error.to_string())?;
    if let Some(path) = file {
        let bytes: Vec<u8> = hu.iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(path, bytes).map_err(|error| format!("writing {path}: {error}"))?;
    }
    Ok(took)
}

/// The plane and the file of a request.
fn asked<'a>(words: &[&'a str]) -> Result<(SlicePlane, Option<&'a str>), String> {
    let numbers: Result<Vec<f64>, _> = words.iter().take(11).map(|word| word.parse()).collect();
    let numbers = numbers.map_err(|error| format!("not a number: {error}"))?;
    let &[ox, oy, oz, rx, ry, rz, dx, dy, dz, width, height] = &numbers[..] else {
        return Err(format!("{} numbers; 11 are needed", numbers.len()));
    };
    let (right, down) = (Vector::new(rx, ry, rz), Vector::new(dx, dy, dz));
    let axes = right.direction().zip(down.direction()).ok_or("a step is zero")?;
    let half = |n: f64| (n - 1.0) / 2.0;
    let centre = Point::new(ox, oy, oz) + right * half(width) + down * half(height);
    let size = [width, height].map(|n| n as u32);
    let plane = SlicePlane::centred(centre, orthogonal(axes.0, axes.1), right.norm(), size);
    Ok((plane.map_err(|error| error.to_string())?, words.get(11).copied()))
}
