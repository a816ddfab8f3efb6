//! The `slice-view-proc` process.

use recorder::replay::instant::{Place, instant};
use slice_view_proc::{At, Recorded};

fn main() -> std::process::ExitCode {
    slice_view_proc::cli::main(
        (volume_loader::load_seeded, volume_loader::load_labels),
        |recording, at| {
            let place = match at {
                At::Time(text) => Place::At(text),
                At::Seq(seq) => Place::Seq(*seq),
            };
            let found = instant(recording, place)?;
            let tissue = found.tissue.map(|(mesh, state)| {
                let (mesh, state) = ((mesh.header, mesh.bytes), *state);
                (mesh, (state.header, state.nodes))
            });
            Ok(Recorded {
                scene: found.scene,
                volume_hash: found.volume_hash,
                pose: found.pose,
                behind_s: found.behind_s,
                standstill_judged: found.standstill_judged,
                guide: found.guide,
                tissue,
            })
        },
    )
}
