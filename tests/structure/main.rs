//! The house itself.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod circles;
mod documents;
mod floors;
mod licences;
mod publishers;
mod reasons;
mod remote;
