//! Floor 3: the connection to a real localizer. It dials, speaks the localizer's protocol, and publishes what that delivers as
//! frames of markers, or of single emitters, each of one instant; nothing else. What the frames mean for the patient is the tracker's
//! business.
//!
//! * `link` dials, reads and writes, and dials again for ever; a peer that is not there is a state, not an error.
//! * `driver` is what a protocol does with bytes and time: `openigtlink`, `ndi`.
//! * `single` holds the single markers of a device against their definitions.
//! * `attention` knows whether this process stood still, so that nobody saw when something came.
//! * `newest` and `again` know a message that comes once more, and a peer that sends nothing else.
//! * `memory` is what the next process is to know of the peer, should this one die.
//! * `clocks` makes of a localizer's stamps the time of a capture on the run's clock.
//! * `image_clock` holds images to the clock of the poses, by how late they come.
//! * `simulate` is the other side: a simulated device of NDI for whoever dials.
//! * `output` numbers, stamps and publishes frames, `image_output` the images of an ultrasound scanner on the same connection.

#![forbid(unsafe_code)]

mod again;
mod attention;
pub mod cli;
pub mod clocks;
mod decode;
pub mod driver;
mod image_clock;
mod image_output;
mod link;
mod memory;
mod ndi;
mod newest;
mod openigtlink;
mod output;
pub mod run;
pub mod simulate;
mod state;
mod stream;
mod waiting;
