//! A comparison as files.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use picture::{PngError, write_png};

use super::{Compared, Summary, plot};

/// Why the results are not there.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OutputError {
    /// A file.
    #[error("writing {path}: {source}. Name a folder that you may write into, with `--out DIR`")]
    File {
        /// The file or the folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The chart.
    #[error(transparent)]
    Png(#[from] PngError),
}

/// Writes `compare.csv`, `compare.json` and `compare.png` into `folder`.
///
/// # Errors
/// [`OutputError`].
pub(crate) fn write(compared: &Compared, summary: &Summary, folder: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(folder).map_err(failed(folder))?;
    let path = folder.join("compare.csv");
    table(compared, &path).map_err(failed(&path))?;
    let path = folder.join("compare.json");
    let json = serde_json::to_string_pretty(summary).unwrap_or_default() + "\n";
    fs::write(&path, json).map_err(failed(&path))?;
    write_png(&folder.join("compare.png"), &plot::draw(compared, summary), &[])?;
    Ok(())
}

fn failed(path: &Path) -> impl FnOnce(io::Error) -> OutputError {
    let path = path.to_owned();
    move |source| OutputError::File { path, source }
}

/// One line for each number that both have. Numbers are written so that they read back to the same bits; without a pose in
/// both there is no difference, and without one no tip: those fields are empty.
fn table(compared: &Compared, path: &Path) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    writeln!(
        file,
        "seq,t_device_s,status_a,status_b,tip_mm,dx_l_mm,dy_p_mm,dz_s_mm,angle_deg,\
         a_l_mm,a_p_mm,a_s_mm,b_l_mm,b_p_mm,b_s_mm"
    )?;
    for d in &compared.differences {
        let t_s = bus::clock::ms(d.t_device_ns) / 1e3;
        write!(file, "{},{t_s},{},{}", d.seq, d.status[0], d.status[1])?;
        match (d.apart, d.tip_mm()) {
            (Some(([x, y, z], angle)), Some(tip)) => write!(file, ",{tip},{x},{y},{z},{}", angle.to_degrees())?,
            _ => write!(file, ",,,,,")?,
        }
        for tip in d.tips_mm {
            match tip {
                Some([x, y, z]) => write!(file, ",{x},{y},{z}")?,
                None => write!(file, ",,,")?,
            }
        }
        writeln!(file)?;
    }
    file.flush()
}
