//! The arguments of `pilot replay`.

use std::path::PathBuf;

/// Which pictures are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pictured {
    /// Those of the last pose.
    Last,
    /// Those of every so many poses too.
    Every(u64),
}

#[derive(Debug, clap::Args)]
pub(crate) struct ReplayArgs {
    /// The recording.
    #[arg(value_name = "FILE.mcap")]
    pub(crate) recording: PathBuf,
    /// How fast: a number (1 is the speed of the recording), or `max`: as fast as every view draws every pose, none left
    /// out. With `--recompute` and `--recompute-tissue` the default is `max`.
    #[arg(long, default_value = "1", default_value_ifs([("recompute", "true", "max"), ("recompute_tissue", "true", "max")]), value_parser = speed)]
    pub(crate) speed: String,
    /// Begin here: 3.2s behind the recording's first pose.
    #[arg(long, value_name = "TIME", value_parser = place)]
    pub(crate) from: Option<f64>,
    /// End here.
    #[arg(long, value_name = "TIME", value_parser = place)]
    pub(crate) to: Option<f64>,
    /// Begin anew at the end.
    #[arg(long = "loop")]
    pub(crate) looping: bool,
    /// Where the recorded examination lies now, if it is not where it was: a folder with a DICOM series, a file, or
    /// `phantom`.
    #[arg(long)]
    pub(crate) volume: Option<String>,
    /// Which series of that folder, from 1 in the order that the loader lists.
    #[arg(long, value_name = "N", requires = "volume", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) series: Option<u32>,
    /// Another scene than the one in the recording: other views, limits or targets.
    #[arg(long, value_name = "SCENE.toml")]
    pub(crate) scene: Option<PathBuf>,
    /// Makes the poses again, of what the localizer delivered, and says how far they lie from the recorded ones: DIR/compare.csv,
    /// compare.png, compare.json. The new poses are in DIR/recomputed.mcap.
    #[arg(long, conflicts_with = "looping")]
    pub(crate) recompute: bool,
    /// Has a model answer the recorded poses again, those of which the recording says where organs were, and says how far organs lie from the
    /// recorded ones: none, to the bit, by the same program on the same kind of processor. Files as with `--recompute`.
    #[arg(long, conflicts_with_all = ["looping", "recompute", "from"])]
    pub(crate) recompute_tissue: bool,
    /// With this calibration of the tool instead of the recorded run's.
    #[arg(long, value_name = "FILE", requires = "recompute")]
    pub(crate) calibration: Option<PathBuf>,
    /// With this registration of the patient instead of the recorded run's.
    #[arg(long, value_name = "FILE", requires = "recompute")]
    pub(crate) registration: Option<PathBuf>,
    /// Also in another examination than the recorded one (every image says so), and what is readable of a damaged file.
    #[arg(long)]
    pub(crate) force: bool,
    /// Where pictures and report go.
    #[arg(long, default_value = "replay")]
    pub(crate) out: PathBuf,
    /// Pictures as files: of the last pose, of every pose, or of every N-th (into DIR/images; at speed `max`).
    #[arg(long, value_name = "last|every|N", default_value = "last", value_parser = pictured)]
    pub(crate) images: Pictured,
    /// Opens the operator's window on the display that DISPLAY names; everything that moves in it says REPLAY.
    #[arg(long)]
    pub(crate) window: bool,
    /// No window, whatever else is said. Every replay writes its pictures.
    #[arg(long)]
    pub(crate) headless: bool,
    /// Names the run; runs of different names do not see each other.
    #[arg(long, default_value = "replay")]
    pub(crate) run: String,
}

/// A speed, as the replayer understands it.
pub(crate) fn speed(text: &str) -> Result<String, String> {
    let number = || text.parse::<f64>().ok().filter(|times| (0.01..=100.0).contains(times));
    match text == "max" || number().is_some() {
        true => Ok(text.to_owned()),
        false => Err(format!("{text:?}: a speed is a number from 0.01 to 100, or `max`")),
    }
}

/// A place in a recording, seconds: `3.2s`, `500ms`, `1.5m`; a number alone is in seconds.
pub(crate) fn place(text: &str) -> Result<f64, String> {
    let allowed = || format!("{text:?}: a place in a recording is a time from its first pose on: 500ms, 3.2s, 1.5m");
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let number: f64 = text[..split].parse().map_err(|_| allowed())?;
    let unit = match &text[split..] {
        "ms" => 1e-3,
        "s" | "" => 1.0,
        "m" => 60.0,
        "h" => 3600.0,
        _ => return Err(allowed()),
    };
    let seconds = number * unit;
    // 10^9 s are longer than any stamp.
    if (0.0..=1e9).contains(&seconds) {
        Ok(seconds)
    } else {
        Err(allowed())
    }
}

fn pictured(text: &str) -> Result<Pictured, String> {
    match text {
        "last" => Ok(Pictured::Last),
        "every" => Ok(Pictured::Every(1)),
        number => match number.parse() {
            Ok(n) if n > 0 => Ok(Pictured::Every(n)),
            _ => Err(format!("{text:?}: allowed are last, every, or a number: every N-th")),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_speeds_and_pictures() {
        assert_eq!(
            (place("3.2s"), place("500ms"), place("2"), place("1.5m")),
            (Ok(3.2), Ok(0.5), Ok(2.0), Ok(90.0))
        );
        for bad in ["", "s", "-1s", "3 weeks", "nan", "inf", "1e99s"] {
            assert!(place(bad).is_err(), "{bad}");
        }
        assert!(["1", "0.25", "max", "100"].into_iter().all(|good| speed(good).is_ok()));
        assert!(
            ["0", "-1", "101", "nan", "Max", ""]
                .into_iter()
                .all(|bad| speed(bad).is_err())
        );
        assert_eq!(
            (pictured("every"), pictured("30")),
            (Ok(Pictured::Every(1)), Ok(Pictured::Every(30)))
        );
        assert!(pictured("0").is_err() && pictured("some").is_err());
    }
}
