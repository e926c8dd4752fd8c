//! Files on disk: whole or not at all.

mod common;

use std::fs;
use std::path::Path;

use common::{outlines, plain_cube, single_precision};
use glam::DVec3;
use graticule::Hint;
use graticule_io::{Format, ReadError, WriteError, read_file, write_file};

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn every_format_goes_through_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let soup = single_precision(plain_cube());
    for format in Format::ALL {
        let path = folder
            .path()
            .join(format!("Größe 模型.{}", format.extension().to_uppercase()));
        write_file(&path, &soup, None).unwrap();
        let file = read_file(&path).unwrap();
        assert_eq!((file.format, file.warnings), (format, vec![]));
        assert_eq!(outlines(&file.soup), outlines(&soup));
    }
    assert_eq!(names(folder.path()).len(), Format::ALL.len());
}

#[test]
fn a_failed_write_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.obj");
    fs::write(&path, "old").unwrap();
    let mut soup = plain_cube();
    soup.positions[0] = DVec3::NAN;
    assert!(matches!(
        write_file(&path, &soup, None),
        Err(WriteError::NonFinitePosition { .. })
    ));
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names(folder.path()), ["mesh.obj"]);
    soup.positions[0] = DVec3::ZERO;
    write_file(&path, &soup, None).unwrap();
    assert_eq!(names(folder.path()), ["mesh.obj"]);
    assert!(fs::read_to_string(&path).unwrap().starts_with("v 0 0 0\n"));
}

#[test]
fn places_that_cannot_be_written_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let soup = plain_cube();
    let missing = folder.path().join("no/such/folder/mesh.ply");
    assert!(matches!(
        write_file(missing, &soup, None),
        Err(WriteError::Io(_))
    ));
    let nameless = folder.path().join("mesh");
    assert!(matches!(
        write_file(&nameless, &soup, None),
        Err(WriteError::UnknownFormat { .. })
    ));
    assert!(matches!(
        write_file(folder.path(), &soup, Some(Format::Ply)),
        Err(WriteError::Io(_))
    ));
    assert!(names(folder.path()).is_empty());
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_rights_kept() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("a.obj"), folder.path().join("b.obj"));
    fs::write(&file, "old").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    write_file(&link, &plain_cube(), None).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(
        fs::metadata(&file).unwrap().permissions().mode() & 0o777,
        0o640
    );
    assert!(read_file(&file).is_ok());
    write_file("/dev/null", &plain_cube(), Some(Format::Stl)).unwrap();
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn files_that_are_not_there_are_told() {
    let error = read_file("no such file.obj").unwrap_err();
    assert!(matches!(error, ReadError::Io(_)));
    let folder = tempfile::tempdir().unwrap();
    let error = read_file(folder.path()).unwrap_err();
    assert!(matches!(error, ReadError::Io(_)));
    assert!(error.hint().unwrap().contains("folder"), "{error}");
}

#[test]
fn gltf_buffers_are_read_from_beside_the_file_only() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("inner");
    fs::create_dir_all(inner.join("buffers")).unwrap();
    let data: Vec<u8> = [0_f32, 0., 0., 1., 0., 0., 0., 1., 0.]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    for place in ["inner/my data.bin", "inner/buffers/x.bin", "outside.bin"] {
        fs::write(folder.path().join(place), &data).unwrap();
    }
    let read = |uri: &str| {
        let document = serde_json::json!({
            "asset": { "version": "2.0" },
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
            "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
            "buffers": [{ "byteLength": 36, "uri": uri }],
        });
        let path = inner.join("mesh.gltf");
        fs::write(&path, document.to_string()).unwrap();
        read_file(path)
    };
    for uri in ["my%20data.bin", "buffers/x.bin", "./my data.bin"] {
        assert_eq!(read(uri).unwrap().soup.polygons.len(), 1, "{uri}");
    }
    for uri in ["../outside.bin", "missing.bin", "buffers"] {
        assert!(
            matches!(read(uri), Err(ReadError::Malformed { .. })),
            "{uri}"
        );
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path().join("outside.bin"), inner.join("link.bin"))
            .unwrap();
        assert!(
            read("link.bin")
                .unwrap_err()
                .to_string()
                .contains("not in the folder")
        );
    }
}
