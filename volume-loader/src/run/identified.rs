//! Whose examination it is, of what the examination says and what the scene says.

use bus::message::{Identity, IdentitySource, VolumeHash};
use scene::RawIdentity;

use crate::source::{VoxelSource, Whose};

/// The message for the volume with this hash. Where the scene says something, its words stand in the place of the examination's; a
/// generated patient stays one, whatever the scene calls it.
pub(crate) fn identified(source: &dyn VoxelSource, scene: Option<&RawIdentity>, hash: VolumeHash) -> Identity {
    let found = source.whose().unwrap_or_else(|error| {
        bus::stderr_line!("volume-loader: warning: whose examination it is cannot be read: {error}");
        Whose::default()
    });
    let whose = match scene {
        Some(scene) => replaced(found, scene),
        None => found,
    };
    Identity::new(hash, whose.source, whose.words.each_ref().map(String::as_str))
}

fn replaced(found: Whose, scene: &RawIdentity) -> Whose {
    let given = scene.words();
    let source = match found.source {
        IdentitySource::Phantom => IdentitySource::Phantom,
        other if given.iter().all(Option::is_none) => other,
        _ => IdentitySource::Scene,
    };
    let mut given = given.into_iter();
    let words = found
        .words
        .map(|words| given.next().flatten().map_or(words, str::to_owned));
    Whose::said(source, words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phantom_source::PhantomSource;
    use geometry::VolumeGrid;

    const HASH: VolumeHash = VolumeHash([7; 32]);

    /// A generated patient whose file says something else.
    struct Saying(PhantomSource, Whose);

    impl VoxelSource for Saying {
        fn grid(&self) -> &VolumeGrid {
            self.0.grid()
        }
        fn padding_hu(&self) -> i16 {
            0
        }
        fn describe(&self) -> String {
            String::new()
        }
        fn read_slice(&mut self, _: u32, _: &mut [i16]) -> Result<(), crate::source::ReadError> {
            Ok(())
        }
        fn finish(&mut self) -> Result<crate::source::Conversion, crate::source::ReadError> {
            Ok(crate::source::Conversion::default())
        }
        fn whose(&self) -> Result<Whose, crate::source::ReadError> {
            Ok(self.1.clone())
        }
    }

    fn phantom() -> PhantomSource {
        PhantomSource::new(1, [30.0; 3]).unwrap()
    }

    fn file(words: [&str; 5]) -> Saying {
        Saying(
            phantom(),
            Whose::said(IdentitySource::Examination, words.map(str::to_owned)),
        )
    }

    fn scene(name: Option<&str>, description: Option<&str>) -> RawIdentity {
        RawIdentity {
            name: name.map(str::to_owned),
            description: description.map(str::to_owned),
            ..RawIdentity::default()
        }
    }

    #[test]
    fn a_generated_patient_says_phantom_whatever_the_scene_calls_it() {
        let plain = identified(&phantom(), None, HASH);
        assert_eq!((plain.source(), plain.volume()), (IdentitySource::Phantom, HASH));
        assert_eq!(plain.words(), ["PHANTOM", "", "", "", ""]);
        let named = identified(&phantom(), Some(&scene(Some("A^B"), None)), HASH);
        assert_eq!(named.source(), IdentitySource::Phantom);
        assert_eq!(named.words()[0], "A^B");
    }

    #[test]
    fn the_scenes_words_stand_in_the_place_of_the_files() {
        let of_file = file(["F^G", "1", "1950-01-01", "2026-11-20", "abdomen"]);
        let plain = identified(&of_file, None, HASH);
        assert_eq!(plain.source(), IdentitySource::Examination);
        assert_eq!(plain.words(), ["F^G", "1", "1950-01-01", "2026-11-20", "abdomen"]);
        assert_eq!(identified(&of_file, Some(&scene(None, None)), HASH), plain);
        let said = identified(&of_file, Some(&scene(Some("S^T"), Some("thorax"))), HASH);
        assert_eq!(said.source(), IdentitySource::Scene);
        assert_eq!(said.words(), ["S^T", "1", "1950-01-01", "2026-11-20", "thorax"]);
        // Of a file that says nothing.
        let nothing = file([""; 5]);
        assert_eq!(identified(&nothing, None, HASH), Identity::unknown(HASH));
        assert_eq!(
            identified(&nothing, Some(&scene(Some("S^T"), None)), HASH).source(),
            IdentitySource::Scene
        );
    }
}
