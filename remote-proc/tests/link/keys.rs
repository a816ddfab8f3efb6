//! Making keys and reading them.

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::Path;

use rcgen::ExtendedKeyUsagePurpose as Purpose;
use remote_proc::link::keys::{Keys, LoadError, MakeError, Side, make};
use tempfile::TempDir;

use crate::support::authority::{Authority, Says, write};

const SIDES: [Side; 2] = [Side::Sender, Side::Receiver];

fn hosts(of: &[&str]) -> Vec<String> {
    of.iter().map(|host| (*host).to_owned()).collect()
}

fn mode(path: &Path) -> u32 {
    fs::metadata(path).unwrap().mode() & 0o777
}

fn chmod(path: &Path, mode: u32) {
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
}

fn refused(folder: &Path, side: Side) -> LoadError {
    Keys::load(folder, side).unwrap_err()
}

#[test]
fn keys_are_made_for_their_owner_alone_and_both_sides_load_them() {
    let tmp = TempDir::new().unwrap();
    let folder = tmp.path().join("a/b");
    let made = make(&folder, &hosts(&["nav-1.example", "192.168.0.30", "fe80::1"]), 30).unwrap();
    assert_eq!(mode(&folder), 0o700);
    let names = [
        "authority.pem",
        "authority.key",
        "sender.pem",
        "sender.key",
        "receiver.pem",
        "receiver.key",
    ];
    assert_eq!(made.files, names.map(|name| folder.join(name)));
    assert_eq!(fs::read_dir(&folder).unwrap().count(), names.len());
    assert!(made.files.iter().all(|file| mode(file) == 0o600));
    // Neither side needs it.
    fs::remove_file(folder.join("authority.key")).unwrap();
    for side in SIDES {
        let keys = Keys::load(&folder, side).unwrap();
        assert_eq!(
            (keys.name(), keys.authority_name()),
            (side.common_name(), made.authority.as_str())
        );
        assert!((29..=30).contains(&keys.days_left()));
        assert!(!format!("{keys:?}").contains("PRIVATE"));
    }
    let other = make(&tmp.path().join("other"), &hosts(&["nav-1"]), 1).unwrap();
    assert_ne!(other.authority, made.authority);
}

#[test]
fn nothing_is_replaced_and_then_nothing_is_written() {
    for name in [
        "authority.pem",
        "authority.key",
        "sender.pem",
        "sender.key",
        "receiver.pem",
        "receiver.key",
    ] {
        let tmp = TempDir::new().unwrap();
        chmod(tmp.path(), 0o700);
        let path = tmp.path().join(name);
        // A link that leads nowhere is there too.
        symlink("nowhere", &path).unwrap();
        let said = make(tmp.path(), &hosts(&["nav"]), 1).unwrap_err();
        assert!(
            matches!(&said, MakeError::Exists { path: there } if *there == path),
            "{said}"
        );
        assert_eq!(fs::read_dir(tmp.path()).unwrap().count(), 1);
    }
}

#[test]
fn keys_that_cannot_be_are_not_made() {
    let tmp = TempDir::new().unwrap();
    let folder = tmp.path().join("keys");
    for days in [0, 3651, u32::MAX] {
        let said = make(&folder, &hosts(&["nav"]), days).unwrap_err();
        assert!(matches!(said, MakeError::Days { found } if found == days));
    }
    for host in [
        "",
        "*",
        "*.example",
        "nav 1",
        "nav/1",
        "0.0.0.0",
        "::",
        "224.0.0.1",
        "tls/nav",
        "nav:7447",
    ] {
        let said = make(&folder, &hosts(&["nav", host]), 1).unwrap_err();
        assert!(matches!(&said, MakeError::Host { found } if found == host), "{said}");
    }
    for count in [0, 65] {
        let said = make(&folder, &vec!["nav".to_owned(); count], 1).unwrap_err();
        assert!(matches!(said, MakeError::Hosts { found } if found == count));
    }
    assert!(!folder.exists());
    fs::create_dir(&folder).unwrap();
    chmod(&folder, 0o755);
    let said = make(&folder, &hosts(&["nav"]), 1).unwrap_err();
    assert!(matches!(said, MakeError::Open { found: 0o755, .. }), "{said}");
}

#[test]
fn files_that_are_missing_open_to_others_or_no_keys_are_refused_by_name() {
    let tmp = TempDir::new().unwrap();
    let authority = Authority::new("ours");
    for side in SIDES {
        let paths = [
            tmp.path().join("authority.pem"),
            side.certificate_file(tmp.path()),
            side.key_file(tmp.path()),
        ];
        for path in &paths {
            authority.folder(tmp.path(), side, &Says::of(side));
            fs::remove_file(path).unwrap();
            let said = refused(tmp.path(), side);
            assert!(
                matches!(&said, LoadError::Open { path: there, .. } if there == path),
                "{said}"
            );
            for text in [
                "",
                "no PEM",
                "-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n",
            ] {
                write(path, text);
                let said = refused(tmp.path(), side);
                assert!(
                    matches!(&said, LoadError::Content { path: there, .. } if there == path),
                    "{said}"
                );
            }
            write(path, &"#".repeat(1 << 17));
            assert!(matches!(refused(tmp.path(), side), LoadError::Open { .. }));
        }
        authority.folder(tmp.path(), side, &Says::of(side));
        let second = fs::read_to_string(&paths[0]).unwrap().repeat(2);
        write(&paths[0], &second);
        assert!(matches!(refused(tmp.path(), side), LoadError::Content { .. }));
        authority.folder(tmp.path(), side, &Says::of(side));
        for (path, forbidden) in [
            (&paths[2], 0o640),
            (&paths[2], 0o604),
            (&paths[0], 0o622),
            (&paths[1], 0o606),
        ] {
            chmod(path, forbidden);
            let said = refused(tmp.path(), side);
            assert!(
                matches!(said, LoadError::Mode { found, .. } if found == forbidden),
                "{said}"
            );
            chmod(path, 0o600);
        }
        // Certificates are no secret.
        chmod(&paths[1], 0o644);
        Keys::load(tmp.path(), side).unwrap();
    }
}

#[test]
fn certificates_that_a_peer_would_refuse_are_refused_before_anybody_is_dialled() {
    let tmp = TempDir::new().unwrap();
    let authority = Authority::new("ours");
    for side in SIDES {
        let says = |change: &dyn Fn(&mut Says)| {
            let mut says = Says::of(side);
            change(&mut says);
            authority.folder(tmp.path(), side, &says);
            refused(tmp.path(), side)
        };
        let said = says(&|says| says.valid = (-20, -10));
        assert!(matches!(&said, LoadError::Expired { .. }), "{said}");
        assert_eq!(said.to_string().matches(" UTC").count(), 2, "both dates: {said}");
        let said = says(&|says| says.valid = (10, 20));
        assert!(matches!(&said, LoadError::NotYet { .. }), "{said}");
        assert_eq!(said.to_string().matches(" UTC").count(), 2, "both dates: {said}");
        for name in ["", "trocar", "trocar-sender2", "trocar-receiver "] {
            let said = says(&|says| says.name = name.to_owned());
            assert!(
                matches!(&said, LoadError::Name { found, .. } if found == name),
                "{said}"
            );
        }
        let said = says(&|says| says.purposes = vec![Purpose::CodeSigning]);
        assert!(matches!(said, LoadError::Refused { .. }), "{said}");
        // The other side's files under this side's names.
        let other = SIDES[usize::from(side == Side::Sender)];
        authority.folder(tmp.path(), side, &Says::of(other));
        assert!(matches!(refused(tmp.path(), side), LoadError::Name { .. }));

        Authority::valid("ours", (-20, -10)).folder(tmp.path(), side, &Says::of(side));
        let said = refused(tmp.path(), side);
        assert!(
            matches!(&said, LoadError::Expired { name, .. } if name == "ours"),
            "{said}"
        );
    }
}

#[test]
fn files_of_two_sets_are_told_apart() {
    let tmp = TempDir::new().unwrap();
    // Of the same name as well, as a copy of an authority that was made anew would be.
    for name in ["theirs", "ours"] {
        for side in SIDES {
            Authority::new(name).folder(tmp.path(), side, &Says::of(side));
            write(&tmp.path().join("authority.pem"), &Authority::new("ours").pem());
            let said = refused(tmp.path(), side);
            assert!(
                matches!(&said, LoadError::Authority { issuer, .. } if issuer == name),
                "{said}"
            );
            let ours = Authority::new("ours");
            ours.folder(tmp.path(), side, &Says::of(side));
            write(&side.key_file(tmp.path()), &ours.signs(&Says::of(side)).1);
            assert!(matches!(refused(tmp.path(), side), LoadError::KeyOfAnother { .. }));
        }
    }
}
