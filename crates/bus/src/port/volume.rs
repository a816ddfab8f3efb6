//! The volume: one sample of voxels behind a header, mapped by everybody, copied by nobody.

use std::cell::RefCell;
use std::rc::Rc;

use geometry::VolumeGrid;
use iceoryx2::port::publisher::Publisher as IoxPublisher;
use iceoryx2::port::subscriber::Subscriber as IoxSubscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::Alignment;
use iceoryx2::sample::Sample;
use iceoryx2::sample_mut::SampleMut;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use super::handed::{HandedVolume, MappedFile, MappedVoxels};
use super::places::take_place;
use super::{limited, open_error, service_name, transfer_error};
use crate::message::{HeaderError, VolumeHash, VolumeHeader};
use crate::node::{Ipc, patiently};
use crate::topic::VOLUME;
use crate::volume::{ALIGNMENT, Layout, VolumeView};
use crate::{Bus, BusError};

/// Of what the loader takes; see [`ALIGNMENT`].
const BEGINNING: Alignment = Alignment::ALIGN_128;
const _: () = assert!(BEGINNING.value() == ALIGNMENT);

pub(super) fn service(bus: &Bus) -> Result<PortFactory<Ipc, [i16], VolumeHeader>, BusError> {
    let builder = bus
        .node
        .service_builder(&service_name(VOLUME.name)?)
        .publish_subscribe::<[i16]>()
        .user_header::<VolumeHeader>()
        .payload_alignment(BEGINNING);
    limited(builder, &VOLUME)
        .open_or_create()
        .map_err(open_error(VOLUME.name, "join"))
}

/// The loader's end.
#[derive(Debug)]
pub struct VolumePublisher {
    port: IoxPublisher<Ipc, [i16], VolumeHeader>,
    stored: usize,
}

/// Shared memory being filled. Nobody sees it before [`LoanedVolume::publish`]; dropped, it is as if it never was.
#[derive(Debug)]
pub struct LoanedVolume {
    sample: SampleMut<Ipc, [i16], VolumeHeader>,
}

impl VolumePublisher {
    /// Becomes the publisher of the volume, with room for `layout`. Memory is taken page by page as it is written:
    /// check the free space first ([`crate::run::shm_free_bytes`]), or the fill dies of SIGBUS.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, layout: &Layout) -> Result<Self, BusError> {
        // Fits: layouts are limited to 2^32 voxels.
        let stored = layout.stored() as usize;
        patiently(bus, || {
            let port = service(bus)?
                .publisher_builder()
                .initial_max_slice_len(stored)
                // One in history, one being read, one to change over to; the default would ask for dozens.
                .override_sample_preallocation(|_| 3)
                .create()
                .map_err(open_error(VOLUME.name, "publish"))?;
            Ok(Self { port, stored })
        })
    }

    /// Takes the memory for the volume. Nothing is written here: pages are taken as the voxels come, so that a long
    /// read can give signs of life, and a file that breaks its promise costs no memory. What is never written (the
    /// padding of bricks) is zero, or what an earlier volume left there.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn loan(&self) -> Result<LoanedVolume, BusError> {
        let sample = self
            .port
            .loan_slice_uninit(self.stored)
            .map_err(transfer_error(VOLUME.name, "taking memory"))?;
        #[allow(
            unsafe_code,
            reason = "zeroing gigabytes first would silence the process for seconds"
        )]
        // SAFETY: the payload lies in a shared-memory file that this process has mapped. The kernel gives such pages
        // zeroed, and whatever was written there since was i16 too: every value is an initialised i16.
        let sample = unsafe { sample.assume_init() };
        Ok(LoanedVolume { sample })
    }

    /// Delivers the volume to processes that joined since the last call. To be called every few milliseconds: a loader
    /// that publishes once and sleeps gives late joiners nothing.
    pub fn serve_late_joiners(&self) {
        let _ = self.port.update_connections();
    }
}

impl LoanedVolume {
    /// The stored voxels, each to be written at its [`Layout::offset`].
    pub fn voxels_mut(&mut self) -> &mut [i16] {
        self.sample.payload_mut()
    }

    /// Puts the header in front and shows the volume to everybody.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn publish(mut self, header: VolumeHeader) -> Result<(), BusError> {
        let mapped = MappedFile::at(self.sample.payload().as_ptr().addr());
        *self.sample.user_header_mut() = VolumeHeader {
            shm_inode: mapped.map_or(0, |file| file.inode),
            ..header
        };
        self.sample.send().map_err(transfer_error(VOLUME.name, "publishing"))?;
        Ok(())
    }
}

/// A reader's end.
#[derive(Debug)]
pub struct VolumeSubscriber {
    port: Rc<IoxSubscriber<Ipc, [i16], VolumeHeader>>,
    /// What the pilot handed to this process, until it is asked for.
    handed: RefCell<Option<SharedVolume>>,
    /// Another examination than the one handed on, to be given after it.
    other: RefCell<Option<SharedVolume>>,
}

/// The volume, mapped read-only. The memory stays for as long as this is held, whatever becomes of the loader.
#[derive(Debug)]
pub struct SharedVolume {
    header: VolumeHeader,
    grid: VolumeGrid,
    layout: Layout,
    voxels: Voxels,
}

#[derive(Debug)]
enum Voxels {
    Published {
        sample: Sample<Ipc, [i16], VolumeHeader>,
        /// A publisher takes back what it lent to a subscriber that has gone, though the mapping stays.
        _port: Rc<IoxSubscriber<Ipc, [i16], VolumeHeader>>,
    },
    Handed(MappedVoxels),
}

impl VolumeSubscriber {
    /// Subscribes to the volume; a late joiner is given the one that is there.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus) -> Result<Self, BusError> {
        Self::open_with(bus, None)
    }

    /// The same, with what the pilot handed to this process: while no loader serves the run, that is the volume. One that cannot be
    /// the volume is as none.
    pub(crate) fn open_with(bus: &Bus, handed: Option<&HandedVolume>) -> Result<Self, BusError> {
        let port = patiently(bus, || {
            let service = service(bus)?;
            take_place((bus, &service), (VOLUME.name, "subscribe"), |service| {
                service.subscriber_builder().buffer_size(1).history_request(1).create()
            })
        })?;
        let handed = handed.and_then(HandedVolume::map);
        let handed = handed.and_then(|(header, voxels)| SharedVolume::new(header, Voxels::Handed(voxels)).ok());
        Ok(Self {
            port: Rc::new(port),
            handed: RefCell::new(handed),
            other: RefCell::new(None),
        })
    }

    /// A volume that was published since the last call. The first is that of the run, where the pilot handed it on: what a loader
    /// published then is taken in its stead where it is the same examination, and given with the next call where it is not.
    ///
    /// # Errors
    /// [`BusError::Header`] for an impossible header, [`BusError::Transfer`].
    pub fn poll(&self) -> Result<Option<SharedVolume>, BusError> {
        let published = self.receive()?;
        let Some(handed) = self.handed.take() else {
            return Ok(published.or_else(|| self.other.take()));
        };
        match published {
            Some(published) if published.hash() == handed.hash() => Ok(Some(published)),
            published => {
                self.other.replace(published);
                Ok(Some(handed))
            }
        }
    }

    fn receive(&self) -> Result<Option<SharedVolume>, BusError> {
        let sample = self.port.receive().map_err(transfer_error(VOLUME.name, "receiving"))?;
        let volume = sample.map(|sample| {
            let header = *sample.user_header();
            let _port = Rc::clone(&self.port);
            SharedVolume::new(header, Voxels::Published { sample, _port })
        });
        volume.transpose()
    }
}

impl Voxels {
    fn as_slice(&self) -> &[i16] {
        match self {
            Self::Published { sample, .. } => sample.payload(),
            Self::Handed(mapped) => mapped.as_slice(),
        }
    }
}

impl SharedVolume {
    fn new(header: VolumeHeader, voxels: Voxels) -> Result<Self, BusError> {
        let (grid, layout) = (header.grid()?, header.layout()?);
        let found = voxels.as_slice().len() as u64;
        if found != layout.stored() {
            return Err(HeaderError::Length {
                expected: layout.stored(),
                found,
            }
            .into());
        }
        Ok(Self {
            header,
            grid,
            layout,
            voxels,
        })
    }

    /// Opens the memory of a volume that a loader published, to be given to processes that start when the loader has died. `None`
    /// where it has died already.
    pub fn hand_on(&self) -> Option<HandedVolume> {
        match &self.voxels {
            Voxels::Published { sample, .. } => HandedVolume::of(sample.user_header(), sample.payload().as_ptr()),
            Voxels::Handed(_) => None,
        }
    }

    /// The header as it was published.
    pub fn header(&self) -> &VolumeHeader {
        &self.header
    }

    /// The volume's identity.
    pub fn hash(&self) -> VolumeHash {
        self.header.volume_hash()
    }

    /// Where the voxels lie in the patient.
    pub fn grid(&self) -> &VolumeGrid {
        &self.grid
    }

    /// The voxels in place.
    pub fn view(&self) -> VolumeView<'_> {
        VolumeView {
            grid: &self.grid,
            layout: &self.layout,
            voxels: self.voxels.as_slice(),
            // Published from an i16; a hostile value is clamped.
            padding_hu: self.header.padding_hu.clamp(-32_768, 32_767) as i16,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::monotonic_ns;
    use crate::run::RunContext;

    #[test]
    fn bricks_begin_at_cache_lines_for_writers_and_readers() {
        let folder = tempfile::tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        run.store().unwrap();
        let bus = Bus::join(&run).unwrap();
        let dims = [9, 5, 6];
        let layout = Layout::new(dims, [4, 4, 4]).unwrap();
        let (publisher, subscriber) = (
            VolumePublisher::open(&bus, &layout).unwrap(),
            VolumeSubscriber::open(&bus).unwrap(),
        );
        let mut loan = publisher.loan().unwrap();
        assert_eq!(loan.voxels_mut().as_ptr().addr() % ALIGNMENT, 0);
        loan.voxels_mut()[7] = 7;
        let header = VolumeHeader {
            ct_from_voxel: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
            dims,
            brick: [4, 4, 4],
            ..VolumeHeader::default()
        };
        loan.publish(header).unwrap();
        let volume = subscriber.poll().unwrap().unwrap();
        assert_eq!(volume.view().voxels[7], 7);
        assert_eq!(volume.view().voxels.as_ptr().addr() % ALIGNMENT, 0);
        drop((volume, publisher, subscriber, bus));
        run.sweep();
    }
}
