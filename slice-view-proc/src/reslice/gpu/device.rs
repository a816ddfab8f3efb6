//! The graphics card: which one is taken, and how its failures are heard of.
//!
//! wgpu reports most failures apart from the call that made them, and by default panics: here they are kept, and every
//! piece of work ends by asking whether one has come.

use std::future::Future;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use wgpu::{Adapter, AdapterInfo, Backends, DeviceType, DownlevelFlags, Features, Limits, PollType, TextureFormat};

use super::super::ResliceError;

/// A card that takes longer than this for one piece of work is given up, while nobody waits for its images.
const PATIENCE: Duration = Duration::from_secs(5);
/// The same once somebody does. Its programs have run by then, as some drivers compile at the first run.
const PATIENCE_BESIDE_IMAGES: Duration = Duration::from_millis(250);
/// The same for a card that is a program: on a busy machine it waits for its turn as others do.
const PATIENCE_WITH_PROGRAMS: Duration = Duration::from_secs(60);
/// No more of a card's memory than this is taken, per cent of what it offers, where the driver says.
const MEMORY_SHARE: u8 = 90;
/// What is said where there is none.
const NO_HARDWARE: &str = "no hardware GPU";
/// How the files of `/dev` begin through which every driver of a card works: DRM, NVIDIA's own, and Windows' in WSL.
const DEVICES: [(&str, &str); 3] = [("/dev/dri", "renderD"), ("/dev", "nvidia"), ("/dev", "dxg")];
/// The longest failure that is passed on, characters.
const LONGEST_WORDS: usize = 200;

/// Which cards will do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::reslice) enum Accepted {
    /// Real ones.
    Hardware,
    /// Also those that are a program on the CPU.
    Any,
    /// None, as on a machine without drivers.
    #[cfg(test)]
    Nothing,
}

impl Accepted {
    fn backends(self) -> Backends {
        match self {
            Self::Hardware | Self::Any => Backends::VULKAN,
            #[cfg(test)]
            Self::Nothing => Backends::empty(),
        }
    }

    fn takes(self, kind: DeviceType) -> bool {
        self == Self::Any || is_hardware(kind)
    }
}

fn is_hardware(kind: DeviceType) -> bool {
    rank(kind) < 3
}

/// Whether the system has a card at all. To ask the drivers takes each renderer a tenth of a second and 100 MiB.
fn has_hardware() -> bool {
    DEVICES.into_iter().any(|(folder, beginning)| {
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
        files
            .into_iter()
            .any(|file| file.file_name().to_string_lossy().starts_with(beginning))
    })
}

/// The best is first.
fn rank(kind: DeviceType) -> u8 {
    match kind {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}

/// An opened card.
#[derive(Debug)]
pub(super) struct Card {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) info: AdapterInfo,
    pub(super) limits: Limits,
    /// Its sampler weighs 16-bit values.
    pub(super) samples_16_bit: bool,
    patience: Duration,
    fault: Arc<Mutex<Option<String>>>,
}

impl Card {
    /// Opens the best card that is accepted; in words why there is none.
    pub(super) fn open(accepted: Accepted) -> Result<Self, String> {
        let mut refused = Vec::new();
        if accepted == Accepted::Hardware && !has_hardware() {
            return Err(NO_HARDWARE.to_owned());
        }
        for adapter in candidates(accepted) {
            match Self::of(&adapter) {
                Ok(card) => return Ok(card),
                Err(why) => refused.push(format!("{}: {why}", adapter.get_info().name)),
            }
        }
        match (refused.is_empty(), accepted) {
            (false, _) => Err(refused.join("; ")),
            (true, Accepted::Hardware) => Err(NO_HARDWARE.to_owned()),
            (true, _) => Err("no GPU".to_owned()),
        }
    }

    fn of(adapter: &Adapter) -> Result<Self, String> {
        let downlevel = adapter.get_downlevel_capabilities().flags;
        if !downlevel.contains(DownlevelFlags::COMPUTE_SHADERS) {
            return Err("it runs no compute programs".to_owned());
        }
        let offered = adapter.limits();
        // Large volumes need what the card offers of these three; of all else the least, which every driver has.
        let limits = Limits {
            max_texture_dimension_3d: offered.max_texture_dimension_3d,
            max_buffer_size: offered.max_buffer_size,
            max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
            ..Limits::downlevel_defaults()
        };
        let norm = adapter.features() & Features::TEXTURE_FORMAT_16BIT_NORM;
        let (device, queue) = at_once(adapter.request_device(&wgpu::DeviceDescriptor {
            label: None,
            required_features: norm,
            required_limits: limits.clone(),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..wgpu::DeviceDescriptor::default()
        }))?
        .map_err(|error| brief(&error.to_string()))?;
        let filters = |format| adapter.get_texture_format_features(format).flags;
        let filterable = wgpu::TextureFormatFeatureFlags::FILTERABLE;
        Ok(Self {
            fault: listen(&device),
            samples_16_bit: !norm.is_empty() && filters(TextureFormat::R16Snorm).contains(filterable),
            patience: match is_hardware(adapter.get_info().device_type) {
                true => PATIENCE,
                false => PATIENCE_WITH_PROGRAMS,
            },
            info: adapter.get_info(),
            limits,
            device,
            queue,
        })
    }

    /// The card and the interface to it.
    pub(super) fn name(&self) -> String {
        format!("{} ({:?})", self.info.name, self.info.backend)
    }

    /// Refuses to go on after a failure.
    pub(super) fn check(&self) -> Result<(), ResliceError> {
        // A thread that died while it kept a failure has left its words or none: either is whole.
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        fault
            .as_ref()
            .map_or(Ok(()), |words| Err(ResliceError::Gpu(words.clone())))
    }

    /// How long it may take for one piece of work, where nothing else is known.
    pub(super) fn patience(&self) -> Duration {
        self.patience
    }

    /// From now on somebody waits for images, and it is given little time. A program on the CPU waits for its turn as before.
    pub(super) fn hurry(&mut self) {
        if self.is_hardware() {
            self.patience = PATIENCE_BESIDE_IMAGES;
        }
    }

    /// Whether it is no program on the CPU.
    pub(super) fn is_hardware(&self) -> bool {
        is_hardware(self.info.device_type)
    }

    /// Hands over what was queued and waits until it is done, but not longer than `patience`.
    pub(super) fn finish(&self, commands: Option<wgpu::CommandBuffer>, patience: Duration) -> Result<(), ResliceError> {
        let submitted = self.queue.submit(commands);
        // Before the wait: for work that was never handed over there is nothing to wait for.
        self.check()?;
        let wait = PollType::Wait {
            submission_index: Some(submitted),
            timeout: Some(patience),
        };
        if let Err(error) = self.device.poll(wait) {
            // Work that may still be going on holds the buffers: whoever asks again is told this, and not what comes of it.
            keep(&self.fault, format!("no result after {patience:?}: {error}"));
        }
        self.check()
    }
}

/// Runs work on a card; what wgpu still panics at becomes an error.
pub(super) fn guarded<T>(work: impl FnOnce() -> Result<T, ResliceError>) -> Result<T, ResliceError> {
    // The card is not used again after an error, so it does not matter in what state a panic left it.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let words = panic.downcast_ref::<String>().map(String::as_str);
        let words = words.or_else(|| panic.downcast_ref::<&str>().copied());
        Err(ResliceError::Gpu(brief(words.unwrap_or("it failed without a word"))))
    })
}

fn candidates(accepted: Accepted) -> Vec<Adapter> {
    let mut found = adapters(accepted.backends());
    found.retain(|adapter| accepted.takes(adapter.get_info().device_type));
    // Stable: among cards of one kind the driver's order stays.
    found.sort_by_key(|adapter| rank(adapter.get_info().device_type));
    found
}

fn adapters(backends: Backends) -> Vec<Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        // The driver's own checks are for those who write wgpu.
        flags: wgpu::InstanceFlags::empty(),
        memory_budget_thresholds: wgpu::MemoryBudgetThresholds {
            for_resource_creation: Some(MEMORY_SHARE),
            for_device_loss: None,
        },
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    at_once(instance.enumerate_adapters(backends)).unwrap_or_default()
}

/// Keeps the first failure of `device`.
fn listen(device: &wgpu::Device) -> Arc<Mutex<Option<String>>> {
    let fault = Arc::new(Mutex::new(None));
    let heard = Arc::clone(&fault);
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        let words = match error {
            wgpu::Error::OutOfMemory { .. } => "out of memory".to_owned(),
            other => other.to_string(),
        };
        keep(&heard, words);
    }));
    let heard = Arc::clone(&fault);
    device.set_device_lost_callback(move |_, words| keep(&heard, format!("lost: {words}")));
    fault
}

/// Of several failures the first one counts.
fn keep(fault: &Mutex<Option<String>>, words: String) {
    let mut fault = fault.lock().unwrap_or_else(PoisonError::into_inner);
    fault.get_or_insert(brief(&words));
}

/// The result of a future that has no one to wait for, as all of wgpu's outside of browsers.
fn at_once<T>(future: impl Future<Output = T>) -> Result<T, String> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => Ok(result),
        Poll::Pending => Err("the driver keeps it waiting".to_owned()),
    }
}

/// On one line, and not too long.
fn brief(words: &str) -> String {
    let line = words.split_whitespace().collect::<Vec<_>>().join(" ");
    line.chars().take(LONGEST_WORDS).collect()
}
