//! OpenCV's grids on the same images, by a script of its own process.

use std::io::Write;
use std::process::Command;

use nalgebra::Vector2;
use optics::image::Image;

/// What OpenCV made of an image.
pub(crate) struct Peer {
    /// Root mean square distance to the truth, px; none without a grid.
    pub(crate) rms: Option<f64>,
    /// CPU time, ms.
    pub(crate) ms: f64,
}

#[allow(clippy::disallowed_methods, reason = "the other's program is a process of its own")]
fn program(python: &str) -> Command {
    Command::new(python)
}

/// Runs the script on images with the true centres; panics where it cannot be run.
pub(crate) fn peers(python: &str, images: &[(&Image, &[Vector2<f64>])]) -> Vec<Peer> {
    let folder = std::env::temp_dir().join(format!("calib-grid-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/peers/grid_opencv.py");
    let mut command = program(python);
    command.arg(script).args(["10", "10"]);
    for (k, (image, _)) in images.iter().enumerate() {
        let path = folder.join(format!("{k}.pgm"));
        let mut file = std::fs::File::create(&path).unwrap();
        writeln!(file, "P5 {} {} 255", image.width(), image.height()).unwrap();
        let bytes: Vec<u8> = image.samples().iter().map(|s| *s as u8).collect();
        file.write_all(&bytes).unwrap();
        command.arg(path);
    }
    let output = command.output().unwrap();
    let _ = std::fs::remove_dir_all(&folder);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    text.lines()
        .zip(images)
        .map(|(line, (_, centres))| peer(line, centres))
        .collect()
}

/// A line of the script: CPU ms, then x and y of every centre, row by row.
fn peer(line: &str, centres: &[Vector2<f64>]) -> Peer {
    let mut numbers = line.split_whitespace().map(|w| w.parse::<f64>().unwrap());
    let ms = numbers.next().unwrap();
    let points: Vec<f64> = numbers.collect();
    let points: Vec<_> = points
        .chunks_exact(2)
        .map(|p| nalgebra::Vector2::new(p[0], p[1]))
        .collect();
    // In whatever order its grid is counted: each point by the truth nearest to it.
    let off = |p: &nalgebra::Vector2<f64>| centres.iter().map(|c| (c - p).norm_squared()).fold(f64::MAX, f64::min);
    let squares: f64 = points.iter().map(off).sum();
    Peer {
        rms: (!points.is_empty()).then(|| (squares / points.len() as f64).sqrt()),
        ms,
    }
}
