//! The programs that run on the card: one for each filter, put together from the texts in `shaders`.

use scene::Filter;

use super::super::ResliceError;
use super::super::weights::{gain, weights};
use super::device::Card;
use super::texture::Contents;

const COMMON: &str = include_str!("shaders/common.wgsl");
const VOXELS: &str = include_str!("shaders/voxels.wgsl");
const COEFFICIENTS: &str = include_str!("shaders/coefficients.wgsl");
const CONVOLVE: &str = include_str!("shaders/convolve.wgsl");
/// Phases of a voxel in the table of a windowed sinc.
const PHASES: u32 = 4096;

/// A filter, and who weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// The program weighs.
    Exact(Filter),
    /// The sampler weighs; the filter is linear.
    Sampler,
}

impl Way {
    /// What it reads.
    pub(super) fn contents(self) -> Contents {
        match self {
            Self::Sampler => Contents::Fractions,
            Self::Exact(Filter::BSpline) => Contents::Coefficients,
            Self::Exact(_) => Contents::Voxels,
        }
    }

    /// The largest result in a volume of values of at most one.
    pub(super) fn gain(self) -> f64 {
        match self {
            Self::Sampler => 1.0,
            Self::Exact(filter) => gain(filter),
        }
    }

    /// Parts of a HU in which means are added up: as small as 32768 HU times [`Way::gain`] allow in 31 bits.
    pub(super) fn unit(self) -> f32 {
        match self {
            Self::Sampler | Self::Exact(Filter::Nearest | Filter::Linear) => 32_768.0,
            // With the gain of Sinc5, the largest of the three: 6.47 2^15 2^13 = 1.74e9, below 2^31.
            Self::Exact(Filter::Cubic | Filter::Sinc3 | Filter::Sinc5) => 8192.0,
            // 27 2^15 2^11 = 1.81e9.
            Self::Exact(Filter::BSpline) => 2048.0,
        }
    }

    /// Voxels read along one axis for one point.
    pub(super) fn taps(self) -> u32 {
        match self {
            Self::Sampler => 2,
            Self::Exact(filter) => filter.taps() as u32,
        }
    }

    fn source(self) -> String {
        let parts = match self {
            Self::Sampler => vec![include_str!("shaders/sampler.wgsl")],
            Self::Exact(Filter::Nearest) => vec![VOXELS, include_str!("shaders/nearest.wgsl")],
            Self::Exact(Filter::Linear) => vec![VOXELS, include_str!("shaders/linear.wgsl")],
            Self::Exact(Filter::Cubic) => vec![VOXELS, include_str!("shaders/cubic.wgsl"), CONVOLVE],
            Self::Exact(Filter::BSpline) => vec![COEFFICIENTS, include_str!("shaders/b_spline.wgsl"), CONVOLVE],
            Self::Exact(Filter::Sinc3 | Filter::Sinc5) => vec![VOXELS, include_str!("shaders/sinc.wgsl"), CONVOLVE],
        };
        format!("{COMMON}\nconst TAPS: i32 = {};\n{}", self.taps(), parts.join("\n"))
    }

    /// The table of weights that it reads.
    fn table(self) -> Option<Vec<f32>> {
        match self {
            Self::Exact(filter @ (Filter::Sinc3 | Filter::Sinc5)) => Some(phases(filter)),
            _ => None,
        }
    }
}

/// Weights at each phase from fraction 0 to 1, as in the fast back end on the CPU.
fn phases(filter: Filter) -> Vec<f32> {
    let taps = filter.taps();
    let phase = |i: u32| weights(filter, f64::from(i) / f64::from(PHASES));
    let mut table: Vec<f32> = (0..PHASES)
        .flat_map(|i| phase(i).into_iter().take(taps))
        .map(|w| w as f32)
        .collect();
    // At fraction 1 the taps stand one voxel further.
    table.push(0.0);
    table.extend_from_within(..taps - 1);
    table
}

/// A compiled program with what only it reads.
#[derive(Debug)]
pub(super) struct Program {
    pub(super) way: Way,
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) layout: wgpu::BindGroupLayout,
    pub(super) table: Option<wgpu::Buffer>,
    pub(super) sampler: Option<wgpu::Sampler>,
}

impl Program {
    /// Compiles it.
    ///
    /// # Errors
    /// [`ResliceError::Gpu`].
    pub(super) fn new(card: &Card, way: Way) -> Result<Self, ResliceError> {
        let module = card.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(way.source().into()),
        });
        card.check()?;
        let pipeline = card.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            // Taken from the program: table and sampler have a binding only where the program reads them.
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        card.check()?;
        let program = Self {
            way,
            layout: pipeline.get_bind_group_layout(0),
            pipeline,
            table: way.table().map(|table| upload(card, bytemuck::cast_slice(&table))),
            sampler: (way == Way::Sampler).then(|| linear_sampler(card)),
        };
        card.check()?;
        Ok(program)
    }
}

fn upload(card: &Card, bytes: &[u8]) -> wgpu::Buffer {
    let buffer = card.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes.len() as u64,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    card.queue.write_buffer(&buffer, 0, bytes);
    buffer
}

/// Beyond the outermost voxel centres it gives the outermost voxels, which is the border rule.
fn linear_sampler(card: &Card) -> wgpu::Sampler {
    let clamped = wgpu::AddressMode::ClampToEdge;
    card.device.create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u: clamped,
        address_mode_v: clamped,
        address_mode_w: clamped,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means are sums of whole units in 32 bits with a sign: the largest value must fit.
    #[test]
    fn the_largest_result_fits_its_units() {
        for way in Filter::ALL.into_iter().map(Way::Exact).chain([Way::Sampler]) {
            let largest = 32_768.0 * way.gain() * f64::from(way.unit());
            assert!(largest <= f64::from(1_u32 << 31), "{way:?}: {largest}");
        }
    }
}
