//! The text files of a source tree, from a disk or from a test.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Where the measured parts of a workspace are.
const PARTS: [&str; 6] = ["services", "shared", "tests", "Cargo.toml", "README.md", "CHANGELOG.md"];
const EXTENSIONS: [&str; 3] = ["rs", "md", "toml"];

/// Text by path relative to the root of the workspace, with `/` between folders.
pub struct Tree {
    files: BTreeMap<String, String>,
}

impl Tree {
    /// Reads the tree below `root`. Panics if a file is not text.
    pub fn read(root: &Path) -> Self {
        let mut files = BTreeMap::new();
        let mut open: Vec<PathBuf> = PARTS.iter().map(|part| root.join(part)).filter(|path| path.exists()).collect();
        while let Some(path) = open.pop() {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.is_dir() {
                if name != "target" && !name.starts_with('.') {
                    let entries = std::fs::read_dir(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
                    open.extend(entries.map(|entry| entry.unwrap().path()));
                }
            } else if path.extension().is_some_and(|own| EXTENSIONS.iter().any(|extension| own == *extension)) {
                let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
                let relative = path.strip_prefix(root).unwrap().components();
                let parts: Vec<_> = relative.map(|part| part.as_os_str().to_string_lossy()).collect();
                files.insert(parts.join("/"), text);
            }
        }
        Self { files }
    }

    /// A tree of the given files, for self-tests.
    pub fn of(files: &[(&str, &str)]) -> Self {
        let own = |(path, text): &(&str, &str)| ((*path).to_owned(), (*text).to_owned());
        Self { files: files.iter().map(own).collect() }
    }

    /// The text of one file, if it is there.
    pub fn text(&self, path: &str) -> Option<&str> {
        self.files.get(path).map(String::as_str)
    }

    /// Paths and texts of all files, in the order of their paths.
    pub fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files.iter().map(|(path, text)| (path.as_str(), text.as_str()))
    }

    /// Folders directly below `parent` that contain a manifest.
    pub fn packages(&self, parent: &str) -> Vec<String> {
        let manifests = self.files.keys().filter_map(|path| path.strip_suffix("/Cargo.toml"));
        let is_child = |folder: &&str| {
            folder.strip_prefix(parent).and_then(|rest| rest.strip_prefix('/')).is_some_and(|name| !name.contains('/'))
        };
        manifests.filter(is_child).map(str::to_owned).collect()
    }
}
