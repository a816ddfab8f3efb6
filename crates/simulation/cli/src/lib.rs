//! Floor 3: `simulate`, the command line of the quasi-static simulation of solids: a scene file in, pictures of states and
//! fields and a report out.
//!
//! The mechanics are in the crate `simulation`; here are the file, the model made of it, the way from state to state, the
//! pictures and the words. Numbers are in the units that the scene names: no conversion is made, and nothing depends on
//! them. Forces are of a unit of depth.

pub mod cli;
mod draw;
mod model;
mod output;
mod report;
mod run;
mod scene;
mod words;

#[cfg(test)]
mod apart;
#[cfg(test)]
mod mutated;

use std::path::Path;

/// What `simulate check` says of the text of a scene; `path` is for the words of errors.
///
/// # Errors
/// What is wrong with it: line, column, key, what was found and what is allowed.
pub fn check(text: String, path: &Path) -> Result<String, String> {
    let source = scene::Source::parse(text, path).map_err(|error| error.to_string())?;
    let (model, _) = cli::modelled(&source)?;
    Ok(words::described(&source.scene, &model))
}
