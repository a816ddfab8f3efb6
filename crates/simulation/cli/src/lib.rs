//! Floor 3: `simulate`, the command line of the quasi-static simulation of solids: a scene file in, pictures of states and
//! fields and a report out.
//!
//! The mechanics are in the crate `simulation`; here are the file, the model made of it, the way from state to state, the
//! pictures and the words. Numbers are in the units that the scene names: no conversion is made. In the plane nothing depends on
//! them, and forces are of a unit of depth; in space they are mm and N/mm2.

pub mod cli;
mod draw;
mod model;
mod output;
mod report;
mod run;
mod scene;
mod space;
mod words;

#[cfg(test)]
mod apart;
#[cfg(test)]
mod mutated;

use std::path::Path;

pub use space::ReadLabels;

/// What `simulate check` says of the text of a scene; `path` is for the words of errors. Of a scene in space its label map is not
/// read: what needs it is not checked.
///
/// # Errors
/// What is wrong with it: line, column, key, what was found and what is allowed.
pub fn check(text: String, path: &Path) -> Result<String, String> {
    if scene::is_of_space(&text) {
        return space::planned(text, path);
    }
    let source = scene::Source::parse(text, path).map_err(|error| error.to_string())?;
    let (model, _) = cli::modelled(&source)?;
    Ok(words::described(&source.scene, &model))
}
