//! Floor 3: shows a run to 3D Slicer, PLUS, pyigtl and whatever else speaks OpenIGTLink. Nothing comes back: what clients send is asked
//! and answered here, and reaches no topic.
//!
//! * `feed` takes poses, markers, words and images from the bus; `standing` judges what may be said of the tool, `tell`, `points`,
//!   `picture` and `volume` make messages of it, `place` turns the patient from LPS to RAS.
//! * `letter` is a message, encoded once for all clients; `mailbox` holds what waits for one of them, `outlet` is the way out to it with
//!   what is under way (`sending`) and what was not read there (`unread`), `hall` has all of them.
//! * `listen` takes connections, `client` serves one.
//!
//! Threads: one of signs of life and the examination, one of the bus, one of the door, one for each client. A pose is written to a client's
//! socket by the thread of the bus, where that has a real-time priority, nothing else is on its way there and the system takes it at once;
//! whatever else there is, and the rest of what was taken in part, is the client's thread's. Nobody who has something to say waits for a client; a client that takes nothing
//! for a second is closed.

pub mod cli;
mod client;
mod commands;
mod feed;
mod hall;
mod letter;
mod listen;
mod mailbox;
mod origin;
mod outlet;
mod picture;
mod place;
mod points;
mod run;
mod sending;
mod standing;
mod tell;
mod unread;
mod volume;
