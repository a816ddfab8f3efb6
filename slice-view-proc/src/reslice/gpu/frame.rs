//! Drawing an image: in bands of rows, through buffers that are kept from image to image.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use bus::clock::monotonic_ns;
use wgpu::{BufferUsages, Limits};

use super::super::ResliceError;
use super::Timings;
use super::device::Card;
use super::program::Program;
use super::rows::{Band, Most, Rows};
use super::texture::Uploaded;

/// Side of the square of pixels that a workgroup draws.
const TILE: usize = 8;
/// Pixels of a band: 8 MiB of results.
const MOST_PIXELS: usize = 1 << 21;
/// Runs of a band: 16 MiB.
const MOST_RUNS: usize = 1 << 19;
/// Voxels read in a band: well below a second's work, after which drivers give a program up.
const MOST_TAPS: u64 = 1 << 28;

/// The buffers.
#[derive(Debug)]
pub(super) struct Frame {
    band: Band,
    parameters: Kept,
    rows: Kept,
    runs: Kept,
    hu: Kept,
    back: Kept,
    bound: Option<Bound>,
}

/// A buffer that grows.
#[derive(Debug)]
struct Kept {
    usage: BufferUsages,
    buffer: Option<wgpu::Buffer>,
}

/// What a program reads and writes, as long as no buffer grows.
#[derive(Debug)]
struct Bound {
    way: super::program::Way,
    group: wgpu::BindGroup,
}

/// What is drawn with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tools<'a> {
    pub(super) card: &'a Card,
    pub(super) program: &'a Program,
    pub(super) volume: &'a Uploaded,
    /// The longest that it may take for a band.
    pub(super) patience: Duration,
}

impl Kept {
    fn new(usage: BufferUsages) -> Self {
        Self { usage, buffer: None }
    }

    /// Makes it hold `bytes`; whether it is a new one.
    fn hold(&mut self, card: &Card, bytes: u64) -> Result<bool, ResliceError> {
        if self.bytes() >= bytes {
            return Ok(false);
        }
        let most = most_bytes(&card.limits);
        if bytes > most {
            return Err(ResliceError::Gpu(format!(
                "a row needs a buffer of {bytes} bytes; it allows {most}"
            )));
        }
        // Half as much again, so that a turning plane does not make it grow at every step.
        let size = (bytes + bytes / 2).next_multiple_of(256).min(most);
        self.buffer = Some(card.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: self.usage,
            mapped_at_creation: false,
        }));
        card.check()?;
        Ok(true)
    }

    fn bytes(&self) -> u64 {
        self.buffer.as_ref().map_or(0, wgpu::Buffer::size)
    }

    fn get(&self) -> Result<&wgpu::Buffer, ResliceError> {
        self.buffer
            .as_ref()
            .ok_or_else(|| ResliceError::Gpu("a buffer is missing".to_owned()))
    }
}

fn most_bytes(limits: &Limits) -> u64 {
    // A multiple of the 4 bytes of a value.
    limits.max_buffer_size.min(limits.max_storage_buffer_binding_size) / 4 * 4
}

impl Default for Frame {
    fn default() -> Self {
        let input = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        Self {
            band: Band::default(),
            parameters: Kept::new(BufferUsages::UNIFORM | BufferUsages::COPY_DST),
            rows: Kept::new(input),
            runs: Kept::new(input),
            hu: Kept::new(BufferUsages::STORAGE | BufferUsages::COPY_SRC),
            back: Kept::new(BufferUsages::MAP_READ | BufferUsages::COPY_DST),
            bound: None,
        }
    }
}

impl Frame {
    /// Bytes of the buffers on the card.
    pub(super) fn bytes(&self) -> u64 {
        let buffers = [&self.parameters, &self.rows, &self.runs, &self.hu, &self.back];
        buffers.into_iter().map(Kept::bytes).sum()
    }

    /// Forgets what was bound: textures and programs are other ones.
    pub(super) fn unbind(&mut self) {
        self.bound = None;
    }

    /// Draws `rows` into `hu`, `width` pixels a row.
    pub(super) fn draw(
        &mut self,
        tools: Tools<'_>,
        rows: &Rows,
        [padding, width]: [i32; 2],
        hu: &mut [f32],
        timings: &mut Timings,
    ) -> Result<(), ResliceError> {
        let width = width as usize;
        // Memory and time of a piece are bounded: a driver gives a program up that takes too long, and others use the card too.
        let most = Most {
            pixels: MOST_PIXELS,
            runs: MOST_RUNS,
            points: MOST_TAPS / u64::from(tools.program.way.taps()).pow(3),
        };
        let (mut first, height) = (0, hu.len() / width);
        while first < height {
            let t0 = monotonic_ns();
            let done = rows.fill(first, most, &mut self.band);
            let pixels = &mut hu[done.start * width..done.end * width];
            let t1 = monotonic_ns();
            timings.plan_ns += t1 - t0;
            // Nothing of the volume is seen in these rows: no work for the card.
            if self.band.runs.is_empty() {
                pixels.fill(padding as f32);
            } else {
                let parameters = rows.parameters(done.len(), padding as i16, tools.program.way);
                self.hold(tools, pixels.len())?;
                self.run(tools, &parameters, [width, done.len()])?;
                let t2 = monotonic_ns();
                timings.run_ns += t2 - t1;
                self.read(tools.card, pixels)?;
                timings.read_ns += monotonic_ns() - t2;
            }
            first = done.end;
        }
        Ok(())
    }

    /// Makes the buffers large enough and binds them.
    fn hold(&mut self, tools: Tools<'_>, pixels: usize) -> Result<(), ResliceError> {
        let card = tools.card;
        let bytes = |n: usize, each: usize| (n * each) as u64;
        // In bytes: 20 words of parameters, 2 words a row, 8 words a run, one value a pixel.
        let grown = [
            self.parameters.hold(card, 80)?,
            self.rows.hold(card, bytes(self.band.rows.len(), 8))?,
            self.runs.hold(card, bytes(self.band.runs.len(), 32))?,
            self.hu.hold(card, bytes(pixels, 4))?,
        ];
        // Only copied to, never bound: that it has grown does not matter to the group.
        self.back.hold(card, bytes(pixels, 4))?;
        let fits = self.bound.as_ref().is_some_and(|b| b.way == tools.program.way);
        if !fits || grown.contains(&true) {
            self.bound = Some(self.bind(tools)?);
        }
        Ok(())
    }

    fn bind(&self, tools: Tools<'_>) -> Result<Bound, ResliceError> {
        let Tools {
            card, program, volume, ..
        } = tools;
        let buffers = [&self.parameters, &self.rows, &self.runs, &self.hu];
        let mut entries = Vec::with_capacity(7);
        for (binding, kept) in (0..).zip(buffers) {
            entries.push(entry(binding, kept.get()?.as_entire_binding()));
        }
        entries.push(entry(4, wgpu::BindingResource::TextureView(&volume.view)));
        entries.extend(program.table.as_ref().map(|table| entry(5, table.as_entire_binding())));
        entries.extend(
            program
                .sampler
                .as_ref()
                .map(|s| entry(6, wgpu::BindingResource::Sampler(s))),
        );
        let group = card.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &program.layout,
            entries: &entries,
        });
        // The driver tells of a failure here only through its own channel.
        card.check()?;
        Ok(Bound {
            way: program.way,
            group,
        })
    }

    /// Hands the band over, runs the program, and waits until the results can be read.
    fn run(&self, tools: Tools<'_>, parameters: &[u32; 20], [width, rows]: [usize; 2]) -> Result<(), ResliceError> {
        let Tools { card, program, .. } = tools;
        let Some(bound) = &self.bound else { return Ok(()) };
        let (queue, results) = (&card.queue, (width * rows * 4) as u64);
        queue.write_buffer(self.parameters.get()?, 0, bytemuck::cast_slice(parameters));
        queue.write_buffer(self.rows.get()?, 0, bytemuck::cast_slice(&self.band.rows));
        queue.write_buffer(self.runs.get()?, 0, bytemuck::cast_slice(&self.band.runs));
        let mut encoder = card
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&program.pipeline);
            pass.set_bind_group(0, &bound.group, &[]);
            let [x, y] = [width, rows].map(|n| n.div_ceil(TILE) as u32);
            pass.dispatch_workgroups(x, y, 1);
        }
        let back = self.back.get()?;
        encoder.copy_buffer_to_buffer(self.hu.get()?, 0, back, 0, results);
        // The callback runs on whatever thread polls the card.
        let mapped = Arc::new(AtomicBool::new(false));
        let heard = Arc::clone(&mapped);
        encoder.map_buffer_on_submit(back, wgpu::MapMode::Read, 0..results, move |result| {
            heard.store(result.is_ok(), Ordering::Relaxed);
        });
        card.finish(Some(encoder.finish()), tools.patience)?;
        match mapped.load(Ordering::Relaxed) {
            true => Ok(()),
            false => Err(ResliceError::Gpu("its results cannot be read".to_owned())),
        }
    }

    /// Copies the results out.
    fn read(&self, card: &Card, pixels: &mut [f32]) -> Result<(), ResliceError> {
        let back = self.back.get()?;
        let range: Range<u64> = 0..size_of_val(pixels) as u64;
        {
            let view = back.get_mapped_range(range);
            let view = view.map_err(|error| ResliceError::Gpu(error.to_string()))?;
            bytemuck::cast_slice_mut(pixels).copy_from_slice(&view);
        }
        back.unmap();
        card.check()
    }
}

fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}
