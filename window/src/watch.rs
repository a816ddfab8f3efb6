//! The program that reads the window's picture back off the screen, and covers it in red when it must not be believed.
//!
//! A window that hangs, starves or dies cannot say so. This is another process: it knows the window by what stands on the screen alone,
//! the coded cell ([`crate::code`]), which it reads out of the root's pixels many times a second. What it sees is judged by a pure
//! function ([`judge::step`]); everything else here moves pixels.

pub mod cli;
mod cover;
mod drawing;
mod error;
mod eyes;
mod find;
pub mod judge;
mod pixels;
mod run;
mod screen;
mod stream;
pub mod words;

pub use error::RunError;
pub(crate) use run::NAME;
