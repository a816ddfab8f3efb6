//! A card that is looked for beside the drawing: drivers take from a tenth of a second to several.

use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, channel};
use std::time::Duration;

use scene::{GpuWeights, Sampling};

use super::Gpu;
use super::gpu::Accepted;

/// A process that ends while a driver opens a card waits so long for it: some crash when they are cut off.
const PARTING: Duration = Duration::from_secs(1);

/// A card on its way: opened, its programs compiled and run once.
#[derive(Debug)]
pub(super) struct Opening(Option<Receiver<Result<Box<Gpu>, String>>>);

impl Opening {
    /// Begins.
    pub(super) fn new(accepted: Accepted, weights: GpuWeights, samplings: Vec<Sampling>) -> Self {
        let (sender, receiver) = channel();
        let open = move || {
            // Compiling takes long, and images are drawn meanwhile.
            bus::process::leave_real_time();
            let opened = Gpu::open(accepted, weights).and_then(|mut gpu| match gpu.rehearse(&samplings) {
                Ok(()) => Ok(Box::new(gpu)),
                Err(error) => Err(error.to_string()),
            });
            // Nobody waits any more where the process ends.
            let _ = sender.send(opened);
        };
        let started = std::thread::Builder::new().name("gpu".to_owned()).spawn(open);
        Self(started.is_ok().then_some(receiver))
    }

    /// The card, or in words why there is none; `None` as long as that is not known. To be asked until it is.
    pub(super) fn opened(&mut self) -> Option<Result<Box<Gpu>, String>> {
        let opened = match self.0.as_ref().map(Receiver::try_recv) {
            Some(Err(TryRecvError::Empty)) => return None,
            Some(Ok(opened)) => opened,
            None | Some(Err(TryRecvError::Disconnected)) => Err("its driver cannot be asked".to_owned()),
        };
        // A channel that has given its card would be taken for a driver that died.
        self.0 = None;
        Some(opened)
    }
}

impl Drop for Opening {
    fn drop(&mut self) {
        let waited = self.0.as_ref().map(|receiver| receiver.recv_timeout(PARTING));
        if let Some(Err(RecvTimeoutError::Timeout)) = waited {
            bus::stderr_line!("slice-view-proc: warning: the GPU's driver does not come back");
        }
    }
}
