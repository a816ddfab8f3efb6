//! The folder of results of a scene in space.

use std::path::Path;

use picture::{Canvas, PngError, write_animation, write_png};

use super::draw::Album;
use super::report::{Report, Whole};
use crate::draw::sheet::{chosen, grid};
use crate::output::{FRAME_MS, MOST_FRAMES, OutputError, json, latin};

/// Pictures in a row of the strip.
const ROW: usize = 2;

/// Writes the report alone: what was found so far.
///
/// # Errors
/// [`OutputError`].
pub(super) fn keep(whole: &Whole<'_>, out: &Path) -> Result<(), OutputError> {
    json(&Report::new(whole, &[]), &out.join("result.json"))
}

/// Writes everything; the names of the pictures.
///
/// # Errors
/// [`OutputError`].
pub(super) fn write(whole: &Whole<'_>, out: &Path) -> Result<Vec<String>, OutputError> {
    let mut pictures = Vec::new();
    let album = Album::new(whole);
    let states = &whole.run.states;
    let mut png = |name: &str, canvas: &Canvas, label: &str| -> Result<(), PngError> {
        let texts = [
            ("Title", latin(whole.title)),
            ("State", latin(label)),
            ("Kind", "MODEL".to_owned()),
        ];
        write_png(&out.join(name), canvas, &texts)?;
        pictures.push(name.to_owned());
        Ok(())
    };
    if let Some(first) = states.first().filter(|_| states.len() > 1) {
        png("start.png", &album.shape(first), &first.label)?;
    }
    if let Some(last) = states.last() {
        png("shape.png", &album.shape(last), &last.label)?;
        png("cuts.png", &album.cuts(last), &last.label)?;
    }
    if states.len() > 2 {
        let small = |most: usize| -> Vec<Canvas> {
            chosen(states.len(), most)
                .into_iter()
                .map(|k| album.small(&states[k]))
                .collect()
        };
        if whole.plan.strip > 0 {
            png("strip.png", &grid(&small(whole.plan.strip), ROW), "strip")?;
        }
        write_animation(&out.join("film.png"), &small(MOST_FRAMES), FRAME_MS)?;
        pictures.push("film.png".to_owned());
    }
    json(&Report::new(whole, &pictures), &out.join("result.json"))?;
    Ok(pictures)
}
