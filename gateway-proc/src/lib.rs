//! Floor 3: shows a run to 3D Slicer, PLUS, pyigtl and whatever else speaks OpenIGTLink. Nothing comes back: what clients send is asked
//! and answered here, and reaches no topic.
//!
//! * `feed` takes poses, markers, words and images from the bus; `standing` judges what may be said of the tool, `tell`, `points`,
//!   `picture` and `volume` make messages of it, `place` turns the patient from LPS to RAS.
//! * `letter` is a message, encoded once for all clients; `mailbox` holds what waits for one of them, `hall` all of them.
//! * `listen` takes connections, `client` serves one.
//!
//! Threads: one of signs of life and the examination, one of the bus, one of the door, one for each client. Nobody who has something to
//! say waits for a client; a client that takes nothing for a second is closed.

pub mod cli;
mod client;
mod commands;
mod feed;
mod hall;
mod letter;
mod listen;
mod mailbox;
mod origin;
mod picture;
mod place;
mod points;
mod run;
mod standing;
mod tell;
mod volume;
