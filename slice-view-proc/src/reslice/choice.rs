//! Which back end draws: as the scene asks, as the machine allows, and as long as the card draws what the CPU draws.
//!
//! The CPU is made ready first and draws while a card is looked for, loaded and proved ([`Proving`]). From then on the card draws,
//! and of each image some pixels are computed again by the CPU. An image that the card fails at, is late with or has wrong is drawn
//! by the CPU in the same call, and the card is not asked again.

use std::time::Duration;

use bus::clock::{monotonic_ns, ns};
use bus::message::GPU_GIVEN_UP;
use bus::volume::VolumeView;
use geometry::SlicePlane;
use scene::{BackEnd, Filter, Render, Sampling};

use super::gpu::Accepted;
use super::opening::Opening;
use super::pace::Pace;
use super::proving::Proving;
use super::watch::Drawn;
use super::{Cpu, Gpu, Resampler, ResliceError};

/// The back end of a scene, with the CPU behind it.
#[derive(Debug)]
pub struct Chosen {
    cpu: Cpu,
    card: Card,
    render: Render,
    samplings: Vec<Sampling>,
    name: String,
    /// What every image says once a card that drew draws no more.
    caution: &'static str,
    pace: Pace,
    /// Images of the card so far.
    drawn: u64,
}

/// How far a card has come.
#[derive(Debug)]
enum Card {
    /// None is used, from the beginning or any more.
    None,
    /// One is to be looked for when it is known what for.
    Wanted(Accepted),
    Opening(Opening),
    Proving(Proving),
    Drawing(Box<Gpu>),
}

/// Why a card that drew is given up.
#[derive(Debug, Clone, Copy)]
enum Fall {
    Lost,
    Late,
    Wrong,
    /// It draws as it should, and the CPU draws faster.
    Slower,
}

impl Fall {
    fn word(self) -> &'static str {
        match self {
            Self::Lost => "lost",
            Self::Late => "late",
            Self::Wrong => "wrong",
            Self::Slower => "slower",
        }
    }

    fn caution(self) -> &'static str {
        match self {
            Self::Lost => "GPU LOST, CPU DRAWS",
            Self::Late => "GPU LATE, CPU DRAWS",
            Self::Wrong => "GPU WRONG, CPU DRAWS",
            Self::Slower => "",
        }
    }
}

impl Chosen {
    /// The back end that `render` asks for; [`BackEnd::Cpu`] does not even look for a card.
    pub fn new(render: Render) -> Self {
        Self::among(
            render,
            match render.back_end {
                BackEnd::Cpu => None,
                BackEnd::Auto => Some(Accepted::Hardware),
                BackEnd::Gpu => Some(Accepted::Any),
            },
        )
    }

    pub(super) fn among(render: Render, accepted: Option<Accepted>) -> Self {
        let cpu = Cpu::default();
        Self {
            name: cpu.name().to_owned(),
            cpu,
            card: accepted.map_or(Card::None, Card::Wanted),
            render,
            samplings: Vec::new(),
            caution: "",
            pace: Pace::default(),
            drawn: 0,
        }
    }

    /// The CPU alone: the same bits on every machine.
    pub fn exact(&mut self) -> &mut Cpu {
        &mut self.cpu
    }

    /// Goes on with making a card ready, for some milliseconds; `volume` is that of [`Resampler::prepare`]. Returns whether there
    /// is more to do.
    pub fn advance(&mut self, volume: &VolumeView<'_>) -> bool {
        match std::mem::replace(&mut self.card, Card::None) {
            Card::Opening(mut opening) => match opening.opened() {
                None => self.card = Card::Opening(opening),
                Some(Ok(gpu)) => self.prove(gpu, volume),
                Some(Err(why)) => self.do_without(&why),
            },
            Card::Proving(mut proving) => match proving.step(volume, &mut self.cpu) {
                Ok(false) => self.card = Card::Proving(proving),
                Ok(true) => self.take(proving),
                Err(why) => {
                    close(proving.into_gpu());
                    self.give_up("unusable", &why);
                }
            },
            other => self.card = other,
        }
        matches!(self.card, Card::Opening(_) | Card::Proving(_))
    }

    /// Waits until it is settled who draws, for who has nothing to show meanwhile.
    pub fn settle(&mut self, volume: &VolumeView<'_>) {
        while self.advance(volume) {
            if matches!(self.card, Card::Opening(_)) {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
    }

    /// The name, with the memory taken on the card: what a process says of itself.
    pub fn note(&self) -> String {
        match (self.gpu_bytes(), &self.card) {
            (Some(bytes), _) => format!("{}, {} MiB", self.name, bytes.div_ceil(1 << 20)),
            (None, Card::Opening(_) | Card::Proving(_)) => format!("{} (a GPU is being tried)", self.name),
            _ => self.name.clone(),
        }
    }

    /// Bytes taken on the card; `None` where the CPU draws.
    pub fn gpu_bytes(&self) -> Option<u64> {
        self.gpu().map(Gpu::bytes)
    }

    /// The card that draws.
    pub(super) fn gpu(&self) -> Option<&Gpu> {
        match &self.card {
            Card::Drawing(gpu) => Some(gpu),
            _ => None,
        }
    }

    /// The card that is proved.
    #[cfg(test)]
    pub(super) fn on_trial(&self) -> Option<&Gpu> {
        match &self.card {
            Card::Proving(proving) => Some(proving.gpu()),
            _ => None,
        }
    }

    /// Watches the speed of a card whatever its kind.
    #[cfg(test)]
    pub(super) fn take_for_hardware(&mut self) {
        self.render.back_end = BackEnd::Auto;
    }

    /// What the CPU's images took, to be set in a test.
    #[cfg(test)]
    pub(super) fn pace(&mut self) -> &mut Pace {
        &mut self.pace
    }

    fn prove(&mut self, gpu: Box<Gpu>, volume: &VolumeView<'_>) {
        match Proving::new(gpu, volume, &self.samplings) {
            Ok(proving) => self.card = Card::Proving(proving),
            Err(why) => self.give_up("unusable", &why),
        }
    }

    fn take(&mut self, proving: Proving) {
        let gpu = proving.into_gpu();
        self.name = gpu.name().to_owned();
        self.card = Card::Drawing(gpu);
    }

    /// There is no card. Who asked for one by name is told so.
    fn do_without(&mut self, why: &str) {
        self.name = format!("{} ({why})", self.cpu.name());
        if self.render.back_end == BackEnd::Gpu {
            warn(&self.name);
        }
    }

    /// A card is there and is not used from now on.
    fn give_up(&mut self, how: &str, why: &str) {
        self.name = format!("{} ({} {how}: {why})", self.cpu.name(), GPU_GIVEN_UP);
        warn(&self.name);
    }

    fn fall(&mut self, fall: Fall, why: &str) {
        match fall {
            // Nothing is wrong with the card or with any image: no more than where there is none.
            Fall::Slower => self.name = format!("{} (the GPU is slower: {why})", self.cpu.name()),
            Fall::Lost | Fall::Late | Fall::Wrong => self.give_up(fall.word(), why),
        }
        self.caution = fall.caution();
        if let Card::Drawing(gpu) = std::mem::replace(&mut self.card, Card::None) {
            close(gpu);
        }
    }

    /// Draws with the card and has the image checked; in words why that is not to be shown.
    fn by_card(
        &mut self,
        volume: &VolumeView<'_>,
        plane: &SlicePlane,
        sampling: &Sampling,
        hu: &mut [f32],
    ) -> Result<Result<(), (Fall, String)>, ResliceError> {
        let Card::Drawing(gpu) = &mut self.card else {
            return Ok(Err((Fall::Lost, "there is none".to_owned())));
        };
        // A program on the CPU is as late as the machine is busy.
        let is_watched = gpu.is_hardware() || self.render.back_end == BackEnd::Auto;
        let patience = self.pace.patience(plane.size(), sampling).filter(|_| is_watched);
        let began = monotonic_ns();
        let drawn = match patience {
            Some(patience) => gpu.reslice_within(volume, plane, sampling, hu, patience),
            None => gpu.reslice(volume, plane, sampling, hu),
        };
        let took_ns = monotonic_ns() - began;
        match drawn {
            // Late and lost come as the same error: the clock tells them apart.
            Err(ResliceError::Gpu(why)) if patience.is_some_and(|patience| took_ns >= ns(patience)) => {
                return Ok(Err((Fall::Late, why)));
            }
            Err(ResliceError::Gpu(why)) => return Ok(Err((Fall::Lost, why))),
            other => other?,
        }
        if let Some(why) = self
            .pace
            .of_card(plane.size(), sampling, took_ns)
            .filter(|_| is_watched)
        {
            return Ok(Err((Fall::Slower, why)));
        }
        let largest_hu = gpu.largest_hu();
        let drawn = Drawn {
            volume,
            plane,
            sampling,
            hu,
            bound_hu: gpu.error_bound_hu(sampling, largest_hu) + self.cpu.error_bound_hu(sampling, largest_hu),
        };
        // As the seed this has other pixels checked in every image, and the same ones in every run.
        self.drawn += 1;
        let deviation = drawn.spot_check(&mut self.cpu, self.drawn)?;
        Ok(deviation.map_or(Ok(()), |deviation| Err((Fall::Wrong, deviation.to_string()))))
    }
}

/// Closes a card on a thread of its own: the driver of one that hangs may keep whoever closes it for seconds.
fn close(gpu: Box<Gpu>) {
    let done = move || {
        bus::process::leave_real_time();
        gpu.close();
    };
    // Without a thread the card is closed here: the closure, and the card in it, are dropped where they are not taken.
    let _ = std::thread::Builder::new().name("gpu".to_owned()).spawn(done);
}

fn warn(name: &str) {
    bus::stderr_line!("slice-view-proc: warning: the CPU draws: {name}");
}

impl Resampler for Chosen {
    fn name(&self) -> &str {
        &self.name
    }

    fn caution(&self) -> &'static str {
        self.caution
    }

    fn error_bound_hu(&self, sampling: &Sampling, max_abs_hu: f64) -> f64 {
        match self.gpu() {
            Some(gpu) => gpu.error_bound_hu(sampling, max_abs_hu),
            None => self.cpu.error_bound_hu(sampling, max_abs_hu),
        }
    }

    /// Makes the CPU ready and begins with a card: [`Chosen::advance`] goes on with that.
    fn prepare(
        &mut self,
        volume: &VolumeView<'_>,
        samplings: &[Sampling],
        alive: &mut dyn FnMut(),
    ) -> Result<(), ResliceError> {
        self.cpu.prepare(volume, samplings, alive)?;
        self.samplings.clear();
        for sampling in samplings {
            if !self.samplings.contains(sampling) {
                self.samplings.push(*sampling);
            }
        }
        match std::mem::replace(&mut self.card, Card::None) {
            Card::Wanted(accepted) => {
                self.card = Card::Opening(Opening::new(accepted, self.render.gpu_weights, samplings.to_vec()));
            }
            // The card is not believed about a volume on which it was not proved.
            Card::Proving(proving) => self.prove(proving.into_gpu(), volume),
            Card::Drawing(gpu) => {
                self.name = self.cpu.name().to_owned();
                self.prove(gpu, volume);
            }
            other => self.card = other,
        }
        Ok(())
    }

    fn reslice_at(
        &mut self,
        volume: &VolumeView<'_>,
        places: &[[f32; 3]],
        filter: Filter,
        hu: &mut [f32],
    ) -> Result<(), ResliceError> {
        self.cpu.reslice_at(volume, places, filter, hu)
    }

    fn reslice(
        &mut self,
        volume: &VolumeView<'_>,
        plane: &SlicePlane,
        sampling: &Sampling,
        hu: &mut [f32],
    ) -> Result<(), ResliceError> {
        if self.gpu().is_some() {
            match self.by_card(volume, plane, sampling, hu)? {
                Ok(()) => return Ok(()),
                Err((fall, why)) => self.fall(fall, &why),
            }
        }
        let began = monotonic_ns();
        self.cpu.reslice(volume, plane, sampling, hu)?;
        self.pace.of_cpu(plane.size(), sampling, monotonic_ns() - began);
        Ok(())
    }
}
