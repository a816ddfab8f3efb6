//! The folder of results: pictures, the strip, the animation, `result.json`.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use nalgebra::Vector2;
use picture::{Canvas, PngError, write_animation, write_png};

use crate::draw::{self, Spec};
use crate::model::Model;
use crate::report::Report;
use crate::run::{Run, State};
use crate::scene::raw::{RawField, RawOutput, RawScene};
use crate::scene::{Checked, named, pair, positive, within};

/// Frames of an animation, at most.
pub(crate) const MOST_FRAMES: usize = 60;
/// How long each is shown.
pub(crate) const FRAME_MS: u16 = 80;

/// What runs write, of scenes in the plane and in space.
const RESULTS: [&str; 10] = [
    "result.json",
    "start.png",
    "shape.png",
    "gradient.png",
    "energy.png",
    "von-mises.png",
    "principal.png",
    "cuts.png",
    "strip.png",
    "film.png",
];

/// What can go wrong with the folder.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OutputError {
    /// It has results already, or something else.
    #[error(
        "writing to {path}: the folder is not empty; give another --out, or --overwrite to replace what has the same names"
    )]
    NotEmpty { path: PathBuf },
    /// The system refused.
    #[error("writing {path}: {source}. Check that the folder may be written to and has space")]
    Io { path: PathBuf, source: io::Error },
    /// A picture.
    #[error(transparent)]
    Picture(#[from] PngError),
}

/// What is drawn, checked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plan {
    region: Option<[Vector2<f64>; 2]>,
    cursors: Option<(usize, f64)>,
}

impl Plan {
    /// # Errors
    /// [`::scene::Invalid`] with the key of a value of `[output]` that cannot be used.
    pub(crate) fn new(raw: &RawOutput, model: &Model) -> Checked<Self> {
        within("output.size.0", raw.size[0] as usize, 200..=4000)?;
        within("output.size.1", raw.size[1] as usize, 200..=4000)?;
        within("output.strip", raw.strip, 0..=24)?;
        within("output.fields", raw.fields.len(), 0..=5)?;
        let region = raw.region.map(|region| -> Checked<_> {
            let low = pair("output.region.low", region.low)?;
            let size = pair("output.region.high", region.high)? - low;
            positive("output.region.high", size.min())?;
            Ok([low, low + size])
        });
        let cursors = raw.cursors.as_ref().map(|c| -> Checked<_> {
            let names = model.solids.iter().map(|s| s.name.as_str());
            let solid = named("output.cursors.solid", &c.solid, names)?;
            Ok((solid, positive("output.cursors.every", c.every)?))
        });
        Ok(Self {
            region: region.transpose()?,
            cursors: cursors.transpose()?,
        })
    }
}

/// Makes the folder, and refuses one with something in it unless told otherwise.
pub(crate) fn folder(path: &Path, overwrite: bool) -> Result<(), OutputError> {
    let io = |source| OutputError::Io {
        path: path.to_owned(),
        source,
    };
    fs::create_dir_all(path).map_err(io)?;
    let mut entries = fs::read_dir(path).map_err(io)?;
    if entries.next().is_some() && !overwrite {
        return Err(OutputError::NotEmpty { path: path.to_owned() });
    }
    // What an earlier run left must not stand beside, or in place of, what this one finds.
    for name in RESULTS {
        match fs::remove_file(path.join(name)) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => return Err(io(source)),
            _ => {}
        }
    }
    Ok(())
}

/// Writes everything; the names of the pictures.
pub(crate) fn write(
    scene: &RawScene,
    model: &Model,
    run: &Run,
    plan: &Plan,
    out: &Path,
) -> Result<Vec<String>, OutputError> {
    let mut album = Album {
        scene,
        model,
        plan,
        region: plan.region.unwrap_or_else(|| draw::region(model, run.states.iter())),
        out,
        pictures: Vec::new(),
    };
    let (first, last) = (run.states.first(), run.states.last());
    if let Some(state) = first.filter(|_| run.states.len() > 1) {
        album.one("start.png", state, RawField::Shape)?;
    }
    if let Some(state) = last {
        for field in fields(&scene.output) {
            album.one(&format!("{}.png", draw::file_word(field)), state, field)?;
        }
    }
    if run.states.len() > 2 {
        album.several(&run.states)?;
    }
    let pictures = album.pictures;
    json(&Report::new(scene, model, run, &pictures), &out.join("result.json"))?;
    Ok(pictures)
}

/// Fields in the order of the file, each once.
fn fields(raw: &RawOutput) -> Vec<RawField> {
    let mut fields = Vec::new();
    for field in &raw.fields {
        if !fields.contains(field) {
            fields.push(*field);
        }
    }
    fields
}

struct Album<'a> {
    scene: &'a RawScene,
    model: &'a Model,
    plan: &'a Plan,
    region: [Vector2<f64>; 2],
    out: &'a Path,
    pictures: Vec<String>,
}

impl<'a> Album<'a> {
    fn spec(&self, states: &[State], field: RawField) -> Spec<'a> {
        Spec {
            title: &self.scene.title,
            units: &self.scene.units,
            field,
            span: draw::span(self.model, states.iter(), field),
            size: self.scene.output.size,
            region: self.region,
            forces: self.scene.output.forces,
            cursors: self.plan.cursors.filter(|_| field == RawField::Shape),
            small: false,
        }
    }

    fn one(&mut self, name: &str, state: &State, field: RawField) -> Result<(), PngError> {
        let spec = self.spec(std::slice::from_ref(state), field);
        let canvas = draw::state(self.model, state, &spec);
        self.png(name, &canvas, &state.label)
    }

    fn several(&mut self, states: &[State]) -> Result<(), PngError> {
        let mut spec = self.spec(states, self.scene.output.film);
        // One range for all: calm states are seen beside the last ones.
        if let Some(span) = &mut spec.span {
            span.ramp = span.ramp.rooted();
        }
        if self.scene.output.strip > 0 {
            let sheet = draw::strip(self.model, states, &spec, self.scene.output.strip);
            self.png("strip.png", &sheet, "strip")?;
        }
        let frames = draw::film(self.model, states, &spec, MOST_FRAMES);
        write_animation(&self.out.join("film.png"), &frames, FRAME_MS)?;
        self.pictures.push("film.png".to_owned());
        Ok(())
    }

    fn png(&mut self, name: &str, canvas: &Canvas, label: &str) -> Result<(), PngError> {
        let texts = [("Title", latin(&self.scene.title)), ("State", latin(label))];
        write_png(&self.out.join(name), canvas, &texts)?;
        self.pictures.push(name.to_owned());
        Ok(())
    }
}

/// PNG texts are Latin-1.
pub(crate) fn latin(text: &str) -> String {
    text.chars().map(|c| if u32::from(c) < 256 { c } else { '?' }).collect()
}

/// Writes the report under a temporary name and renames it.
pub(crate) fn json(report: &impl serde::Serialize, path: &Path) -> Result<(), OutputError> {
    let part = path.with_extension("json.part");
    let text = serde_json::to_string_pretty(report).map_err(io::Error::other);
    let written = text
        .and_then(|text| fs::write(&part, text + "\n"))
        .and_then(|()| fs::rename(&part, path));
    written.map_err(|source| {
        let _ = fs::remove_file(&part);
        OutputError::Io {
            path: path.to_owned(),
            source,
        }
    })
}
