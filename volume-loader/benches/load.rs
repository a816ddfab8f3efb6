//! A DICOM series of 512 x 512 x 500 from a warm cache: ours beside a plain parallel read of the same files and, through
//! `cargo xtask bench load`, beside SimpleITK's series reader, taking turns. The volume loaded is held against the one written.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(clippy::print_stdout, reason = "the table is what this is for")]
#![allow(
    clippy::disallowed_methods,
    reason = "a benchmark measures real time and starts other programs"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::thread;
use std::time::Instant;

use bus::volume::{Hasher, Layout, SliceHash};
use geometry::{Affine, VolumeGrid};
use volume_loader::dicom::{DicomSource, Options, Series};
use volume_loader::dicom_out;
use volume_loader::fill;
use volume_loader::source::{Conversion, ReadError, VoxelSource};

const DIMS: [i64; 3] = [512, 512, 500];
const ROUNDS: usize = 7;

/// Noise by formula: what no cache and no compressor can foresee.
struct Noise {
    grid: VolumeGrid,
}

impl Noise {
    fn new() -> Self {
        let rows = [[0.7, 0.0, 0.0, -180.0], [0.0, 0.7, 0.0, -180.0], [0.0, 0.0, 0.6, 0.0]];
        Self {
            grid: VolumeGrid::checked(DIMS, Affine::from_rows(rows)).unwrap(),
        }
    }
}

impl VoxelSource for Noise {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }
    fn padding_hu(&self) -> i16 {
        -1024
    }
    fn describe(&self) -> String {
        "noise".to_owned()
    }
    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        let mut state = u64::from(k).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        for voxel in out {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            *voxel = (state % 3000) as i16 - 1000;
        }
        Ok(())
    }
    fn finish(&mut self) -> Result<Conversion, ReadError> {
        Ok(Conversion::default())
    }
}

fn threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// Every file read whole, by as many threads as there are cores, into memory that is kept.
fn plain_read(files: &[PathBuf]) {
    let work = Mutex::new(files.iter());
    thread::scope(|scope| {
        for _ in 0..threads() {
            scope.spawn(|| {
                let mut bytes = Vec::new();
                loop {
                    let next = work.lock().unwrap().next();
                    let Some(path) = next else { break };
                    bytes.clear();
                    std::io::Read::read_to_end(&mut fs::File::open(path).unwrap(), &mut bytes).unwrap();
                }
            });
        }
    });
}

/// As the loader does it: scan, judge, read, put into bricks, hash.
fn ours(folder: &Path) -> bus::message::VolumeHash {
    let series = Series::scan(folder).unwrap().choose(None).unwrap();
    let mut source = DicomSource::open(&series, Options::default()).unwrap();
    let layout = Layout::choose(source.grid().dims()).unwrap();
    let mut stored = vec![0; layout.stored() as usize];
    fill(&mut source, &layout, &mut stored, |_| true).unwrap().hash
}

/// The hash of what was written.
fn expected() -> bus::message::VolumeHash {
    let mut noise = Noise::new();
    let grid = noise.grid;
    // What the files say: the same numbers as decimal text.
    let mut hasher = Hasher::new(&grid, noise.padding_hu());
    let mut slice = vec![0; 512 * 512];
    for k in 0..grid.dims()[2] {
        noise.read_slice(k, &mut slice).unwrap();
        hasher.update(SliceHash::of(&slice));
    }
    hasher.finish()
}

/// Seconds that SimpleITK's series reader took, as its script says; `None` where nobody named a Python.
fn simple_itk(folder: &Path) -> Option<f64> {
    let python = std::env::var_os("TROCAR_PEERS_PYTHON")?;
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers/load.py");
    let output = Command::new(python).arg(script).arg(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).trim().parse().ok()
}

fn timed(work: impl FnOnce()) -> f64 {
    let began = Instant::now();
    work();
    began.elapsed().as_secs_f64()
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// The most memory that this process has held, MiB.
fn peak_mib() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|rest| rest.trim().trim_end_matches(" kB").trim().parse::<f64>().ok());
    kib.unwrap_or(f64::NAN) / 1024.0
}

fn main() {
    let folder = tempfile::tempdir().unwrap();
    let series = folder.path().join("series");
    let wrote = timed(|| {
        dicom_out::write(&series, &mut Noise::new(), &dicom_out::Options::default()).unwrap();
    });
    let mut files: Vec<PathBuf> = fs::read_dir(&series)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let pixel_gb = DIMS.iter().product::<i64>() as f64 * 2.0 / 1e9;
    println!(
        "{} files, {pixel_gb:.3} GB of pixels, written in {wrote:.2} s; {} threads",
        files.len(),
        threads()
    );
    let before = peak_mib();
    assert_eq!(ours(&series), expected(), "what was loaded is not what was written");
    println!(
        "peak memory {:.1} MiB, of which the volume {:.1}, {before:.1} held before",
        peak_mib(),
        pixel_gb * 1e9 / 1048576.0
    );
    let (mut plain, mut loaded, mut peer) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        plain.push(timed(|| plain_read(&files)));
        loaded.push(timed(|| {
            ours(&series);
        }));
        peer.extend(simple_itk(&series));
    }
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!(
        "{:<28} {:>9} {:>9} {:>9} {:>8}",
        "", "median, s", "least, s", "GB/s", "ratio"
    );
    let ours_median = median(&mut loaded);
    for (name, times) in [
        ("plain parallel read", &mut plain),
        ("ours: scan, read, brick, hash", &mut loaded),
        ("SimpleITK ImageSeriesReader", &mut peer),
    ] {
        if times.is_empty() {
            println!("{name:<28} not run: `cargo xtask bench load` brings it");
            continue;
        }
        let middle = median(times);
        let (least, rate, ratio) = (times[0], pixel_gb / middle, middle / ours_median);
        println!("{name:<28} {middle:>9.3} {least:>9.3} {rate:>9.2} {ratio:>8.2}");
    }
    println!("load {}", load.split(' ').next().unwrap_or_default());
}
