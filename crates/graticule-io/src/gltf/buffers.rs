use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::json::Root;

use crate::Format;
use crate::error::{Place, Problem, ReadError, quoted};

/// The bytes of all buffers of a document.
pub(super) struct Buffers<'a>(Vec<Cow<'a, [u8]>>);

impl<'a> Buffers<'a> {
    /// Fetches all buffers: from the GLB file itself, from data URIs, or from files beside the
    /// document at `path`; never from the network or from other folders.
    pub(super) fn fetch(
        root: &Root,
        binary: Option<&'a [u8]>,
        path: Option<&Path>,
    ) -> Result<Self, ReadError> {
        let mut buffers = Vec::with_capacity(root.buffers.len());
        for (index, buffer) in root.buffers.iter().enumerate() {
            let claimed = buffer.byte_length.0;
            let place = Place::element("buffer", index);
            let malformed = |problem| ReadError::malformed(Format::Gltf, place.clone(), problem);
            let bytes = match (&buffer.uri, binary) {
                (Some(uri), _) => fetch(uri, path, claimed).map_err(|reason| {
                    malformed(Problem::BufferRefused {
                        uri: quoted(uri.as_bytes()),
                        reason,
                    })
                })?,
                (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
                (None, _) => Cow::Borrowed(&[][..]),
            };
            if claimed > bytes.len() as u64 {
                return Err(malformed(Problem::BeyondBuffer {
                    needed: claimed,
                    source_kind: "data",
                    available: bytes.len() as u64,
                }));
            }
            buffers.push(bytes);
        }
        Ok(Self(buffers))
    }

    pub(super) fn get(&self, index: usize) -> Option<&[u8]> {
        self.0.get(index).map(AsRef::as_ref)
    }

    /// Bytes of all buffers.
    pub(super) fn size(&self) -> u64 {
        self.0.iter().map(|buffer| buffer.len() as u64).sum()
    }
}

/// The bytes at an address, or why they are not to be had.
fn fetch<'a>(uri: &str, document: Option<&Path>, claimed: u64) -> Result<Cow<'a, [u8]>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        return decode_data(data).map(Cow::Owned);
    }
    let Some(document) = document else {
        return Err("it is another file, which cannot be found from bytes alone".to_owned());
    };
    let path = local_path(uri)?;
    let folder = document.parent().unwrap_or(Path::new(""));
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    read_inside(folder, &path, claimed).map(Cow::Owned)
}

fn decode_data(data: &str) -> Result<Vec<u8>, String> {
    let Some((_, text)) = data.split_once(";base64,") else {
        return Err("its data is not in base64".to_owned());
    };
    STANDARD
        .decode(text.as_bytes())
        .map_err(|error| format!("its data is not base64: {error}"))
}

/// A relative path that cannot climb: plain names only.
fn local_path(uri: &str) -> Result<PathBuf, String> {
    if uri.contains("://") || uri.starts_with("//") {
        return Err("only local files are read".to_owned());
    }
    let decoded = decode_percent(uri);
    let path = Path::new(&decoded);
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    if !path.components().all(plain) || decoded.contains(['\\', ':', '\0']) {
        return Err("it is not in the folder of the document".to_owned());
    }
    Ok(path.to_owned())
}

/// Reads a file of at most `limit` bytes, unless links lead out of `folder`.
fn read_inside(folder: &Path, path: &Path, limit: u64) -> Result<Vec<u8>, String> {
    let resolve = |path: &Path| path.canonicalize().map_err(|error| error.to_string());
    let (folder, path) = (resolve(folder)?, resolve(&folder.join(path))?);
    if !path.starts_with(&folder) {
        return Err("it is not in the folder of the document".to_owned());
    }
    let file = File::open(path).map_err(|error| error.to_string())?;
    let metadata = file.metadata().map_err(|error| error.to_string())?;
    if !metadata.is_file() {
        return Err("it is not a regular file".to_owned());
    }
    let mut bytes = Vec::new();
    file.take(limit)
        .read_to_end(&mut bytes)
        .map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// Replaces `%20` and the like; anything else stays.
fn decode_percent(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let digits = tail
            .get(..2)
            .and_then(|digits| std::str::from_utf8(digits).ok());
        let code = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match code {
            Some(code) if *first == b'%' => {
                bytes.push(code);
                rest = &tail[2..];
            }
            _ => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).unwrap_or_else(|_| uri.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_outside_of_the_folder_are_refused() {
        let refused = [
            "../x.bin",
            "a/../../x.bin",
            "/etc/hostname",
            "http://127.0.0.1/x.bin",
            "file:///etc/passwd",
            "//server/x.bin",
            "..%2fx.bin",
            "%2e%2e/x.bin",
            "C:\\x.bin",
            "a\\..\\x.bin",
            "x%00.bin",
        ];
        for uri in refused {
            assert!(local_path(uri).is_err(), "{uri}");
        }
    }

    #[test]
    fn plain_names_are_paths() {
        assert_eq!(
            local_path("my%20mesh.bin").unwrap(),
            Path::new("my mesh.bin")
        );
        assert_eq!(
            local_path("./buffers/x.bin").unwrap(),
            Path::new("./buffers/x.bin")
        );
        assert_eq!(local_path("100%.bin").unwrap(), Path::new("100%.bin"));
    }
}
