//! Files that are there whole or not at all: written under another name beside their place, then
//! renamed.

use crate::error::RecordingError;
use crate::file_name;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Lets `fill` write a file that takes the place of `path` when it is complete; a writer killed on
/// the way leaves what was there, and beside it a `.writing` file that the next write takes over.
/// Pipes and devices are written directly.
pub(crate) fn replace<T>(
    path: &Path,
    fill: impl FnOnce(&Path) -> Result<T, RecordingError>,
) -> Result<T, RecordingError> {
    let io = |action| move |source| RecordingError::Io { file: file_name(path), action, reason: source };
    let target = match std::fs::metadata(path) {
        Ok(found) if !found.is_file() => return fill(path),
        Ok(_) => {
            // A rename would take the place of a file that must not be written.
            OpenOptions::new().write(true).open(path).map_err(io("write"))?;
            path.canonicalize().map_err(io("open"))?
        }
        Err(_) => path.into(),
    };
    let mut temporary = target.clone().into_os_string();
    temporary.push(".writing");
    let temporary = PathBuf::from(temporary);
    let filled = fill(&temporary).inspect_err(|_| {
        let _ = std::fs::remove_file(&temporary);
    })?;
    std::fs::rename(&temporary, &target).map_err(io("replace"))?;
    Ok(filled)
}

/// As [`replace`], for what is written as one stream of bytes; on the device when this returns.
pub(crate) fn replace_stream(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<(), RecordingError> {
    let io = |action| move |source| RecordingError::Io { file: file_name(path), action, reason: source };
    replace(path, |temporary| {
        let mut out = BufWriter::with_capacity(1 << 16, File::create(temporary).map_err(io("create"))?);
        fill(&mut out).and_then(|()| out.flush()).map_err(io("write"))?;
        // A pipe cannot be synchronised and needs not be.
        if out.get_ref().metadata().is_ok_and(|file| file.is_file()) {
            out.get_ref().sync_all().map_err(io("write"))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A test's own folder, gone when the test is.
    struct Folder(PathBuf);

    impl Folder {
        fn new(test: &str) -> Self {
            let path = std::env::temp_dir().join(format!("obsid-whole-file-{test}-{}", std::process::id()));
            std::fs::create_dir_all(&path).unwrap();
            Folder(path)
        }

        fn files(&self) -> Vec<String> {
            let name = |entry: std::io::Result<std::fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
            std::fs::read_dir(&self.0).unwrap().map(name).collect()
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn the_old_file_stands_until_the_new_one_is_complete() {
        let folder = Folder::new("complete");
        let path = folder.0.join("complete");
        std::fs::write(&path, "old").unwrap();
        replace_stream(&path, |out| {
            out.write_all(b"half")?;
            out.flush()?;
            // What a reader, or a kill at this instant, finds.
            assert_eq!(std::fs::read(&path).unwrap(), b"old");
            out.write_all(b" and half")
        })
        .unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"half and half");
        assert_eq!(folder.files(), ["complete"]);
    }

    #[test]
    fn a_write_that_fails_leaves_the_old_file_and_nothing_beside_it() {
        let folder = Folder::new("failed");
        let path = folder.0.join("failed");
        std::fs::write(&path, "old").unwrap();
        let error = replace_stream(&path, |out| {
            out.write_all(b"half")?;
            Err(std::io::Error::other("no space"))
        });
        let error = error.unwrap_err().explain();
        assert!(error.contains("failed: cannot write: no space"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(folder.files(), ["failed"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_a_device_a_device() {
        let folder = Folder::new("link");
        let (target, link) = (folder.0.join("target"), folder.0.join("link"));
        std::fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        replace_stream(&link, |out| out.write_all(b"new")).unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read(&target).unwrap(), b"new");
        replace_stream(Path::new("/dev/null"), |out| out.write_all(b"new")).unwrap();
        assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
    }
}
