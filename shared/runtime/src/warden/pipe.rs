//! Whole lines from a pipe that does not block.

use std::io::Read;

/// Keeps half a line until its rest has come.
#[derive(Default)]
pub(super) struct LineBuffer(Vec<u8>);

impl LineBuffer {
    pub fn read(&mut self, pipe: &mut impl Read) -> Vec<String> {
        let mut chunk = [0; 4096];
        while let Ok(count) = pipe.read(&mut chunk) {
            if count == 0 {
                break;
            }
            self.0.extend_from_slice(&chunk[..count]);
        }
        let mut lines = Vec::new();
        while let Some(end) = self.0.iter().position(|&byte| byte == b'\n') {
            let line: Vec<u8> = self.0.drain(..=end).collect();
            lines.push(String::from_utf8_lossy(&line[..end]).into_owned());
        }
        lines
    }
}
