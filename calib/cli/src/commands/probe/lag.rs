//! `calib lag`: how late poses are behind images, from a motion that both show.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use echo::Region;
use probe::{LagError, LagOptions, MotionLag, lag, principal_motion};

use super::error::SegmentError;
use super::seeing::region;
use super::segment::{Sought, segment};
use crate::commands::Outcome;
use crate::input_files::source::{Source, SourceError};
use crate::poses::{PosesError, timed};

pub(crate) const LAG_HELP: &str = "\
The probe is moved back and forth at changing speed for ten seconds or more over something flat, along the beam or \
along the rows; a number that follows \
that way is read off each image: the row of the line, say. The command finds the time to add to an image's stamp \
to find the pose that goes with it: above 0 where poses \
have later stamps. Which way a number goes does not matter.

Without --signal the row of the line of a flat wall, at the middle column, is read off the images of the sequence: of \
parallel lines the uppermost strong one. The probe's own face shows lines too, which never move: leave them out with \
--region.

The signal is CSV: frame,value with the numbers of the sequence's frames, whose time stamps are taken, or \
t_s,value with times on the clock of the sequence. The way is that of \
the poses along the direction in which they moved most. Numbers far off are let go of.

Refused, with exit code 1: a motion that stands still, goes at one speed, or repeats itself within the range, \
signals that are not alike, and a lag that is less sure than \
--max-sigma-ms.

Examples:
  calib lag --sequence tank.mha --region 0,60,820,600
  calib lag --signal rows.csv --sequence tank.mha
  calib lag --signal rows.csv --sequence tank.mha --transform ProbeToTracker --most-ms 300 --max-sigma-ms 5";

#[derive(Debug, Args)]
pub(crate) struct LagArgs {
    /// The number of each image: frame,value or t_s,value; without it the row of the wall's line is read off the images
    #[arg(long, value_name = "FILE.csv")]
    signal: Option<PathBuf>,
    /// Look at these pixels only: first column and row, and the first ones beyond
    #[arg(long, value_name = "U,V,U,V", conflicts_with = "signal", value_parser = region)]
    region: Option<Region>,
    /// The poses, with time stamps
    #[arg(long, value_name = "FILE.mha")]
    sequence: PathBuf,
    /// The transform of the sequence whose motion the images show
    #[arg(long, value_name = "NAME", default_value = "ProbeToReference")]
    transform: String,
    /// The largest lag either way, 10 to 5000
    #[arg(long, value_name = "MS", default_value = "500")]
    most_ms: f64,
    /// Take the way as the mean of its neighbours in time, weighted by a normal curve of this deviation, 1 to 1000
    #[arg(long, value_name = "MS", default_value = "100")]
    window_ms: f64,
    /// Refuse signals that are less alike
    #[arg(long, value_name = "CORRELATION", default_value = "0.9")]
    min_correlation: f64,
    /// Refuse a lag whose deviation is larger
    #[arg(long, value_name = "MS", default_value = "20")]
    max_sigma_ms: f64,
}

#[derive(Debug, thiserror::Error)]
pub(crate) enum LagCommandError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error(transparent)]
    Poses(#[from] PosesError),
    #[error(transparent)]
    Segment(#[from] SegmentError),
    #[error("reading {path}: line {line}: found {found:?}, expected {expected}")]
    Csv {
        path: PathBuf,
        line: usize,
        found: String,
        expected: &'static str,
    },
    #[error("{path}: frame {frame} is not in {sequence}, or has no time stamp there")]
    NoTime {
        path: PathBuf,
        sequence: PathBuf,
        frame: u32,
    },
    #[error("the lag of {signal} and {sequence}: {source}")]
    Lag {
        signal: PathBuf,
        sequence: PathBuf,
        source: LagError,
    },
}

impl LagArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, LagCommandError> {
        let frames = timed(&self.sequence, &self.transform)?;
        let times: BTreeMap<u32, f64> = frames.iter().filter_map(|f| Some((f.number, f.t_s?))).collect();
        let (image, mut told) = match &self.signal {
            Some(path) => (self.samples(&Source::read(path)?, &times)?, String::new()),
            None => self.seen(&times)?,
        };
        let poses: Vec<_> = frames.iter().filter_map(|f| Some((f.t_s?, f.pose?))).collect();
        let way = principal_motion(&poses);
        let options = LagOptions {
            most_s: self.most_ms / 1000.0,
            window_s: self.window_ms / 1000.0,
            min_correlation: self.min_correlation,
            max_sigma_s: self.max_sigma_ms / 1000.0,
        };
        let found = lag(&image, &way, &options).map_err(|source| LagCommandError::Lag {
            signal: self.signal.clone().unwrap_or_else(|| self.sequence.clone()),
            sequence: self.sequence.clone(),
            source,
        })?;
        told += &text(&found, &way);
        Ok(Outcome {
            text: told,
            refused: None,
        })
    }

    /// The row of the wall in each image that shows it, and what was seen in words.
    fn seen(&self, times: &BTreeMap<u32, f64>) -> Result<(Vec<(f64, f64)>, String), LagCommandError> {
        let found = segment(&self.sequence, self.region, &Sought::Wall, false)?;
        let timed = found
            .rows
            .iter()
            .filter_map(|(frame, row)| Some((*times.get(frame)?, *row)));
        Ok((timed.collect(), found.words()))
    }

    fn samples(&self, source: &Source, times: &BTreeMap<u32, f64>) -> Result<Vec<(f64, f64)>, LagCommandError> {
        let refused = |line: usize, found: &str, expected| LagCommandError::Csv {
            path: source.path.clone(),
            line,
            found: found.chars().take(80).collect(),
            expected,
        };
        let mut rows = source.rows();
        let (line, head) = rows.next().unwrap_or((1, ""));
        let by_frame = match head.split(',').map(str::trim).collect::<Vec<_>>()[..] {
            ["frame", "value"] => true,
            ["t_s", "value"] => false,
            _ => return Err(refused(line, head, "the columns frame,value or t_s,value")),
        };
        rows.map(|(line, text)| {
            let wrong = || refused(line, text, "a frame's number or a time, and a finite number");
            let (first, value) = text.split_once(',').ok_or_else(wrong)?;
            let number = |field: &str| {
                field
                    .trim()
                    .parse::<f64>()
                    .ok()
                    .filter(|x| x.is_finite())
                    .ok_or_else(wrong)
            };
            let value = number(value)?;
            if !by_frame {
                return Ok((number(first)?, value));
            }
            let frame = first.trim().parse().map_err(|_| wrong())?;
            let t_s = times.get(&frame).ok_or_else(|| LagCommandError::NoTime {
                path: source.path.clone(),
                sequence: self.sequence.clone(),
                frame,
            })?;
            Ok((*t_s, value))
        })
        .collect()
    }
}

fn text(found: &MotionLag, way: &[(f64, f64)]) -> String {
    let (low, high) = way.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (_, x)| {
        (a.min(*x), b.max(*x))
    });
    let [used, left] = found.samples;
    format!(
        "lag              {:.1} +- {:.1} ms: an image's pose is that of its own time and this\n\
         motion           {:.1} mm from end to end, {:.4} of the image's units a mm, correlation {:.4}\n\
         images           {used} used, {left} left out as gross errors, residual {:.3} of the image's units\n",
        1e3 * found.lag_s,
        1e3 * found.sigma_s,
        high - low,
        found.gain,
        found.correlation,
        found.residual
    )
}
