//! Whole lines from a pipe that does not block.

use std::io::Read;

/// Keeps half a line until its rest has come.
#[derive(Default)]
pub(super) struct LineBuffer {
    bytes: Vec<u8>,
    /// Nobody writes any more: whoever waits for the pipe would never sleep.
    pub is_closed: bool,
}

impl LineBuffer {
    pub fn read(&mut self, pipe: &mut impl Read) -> Vec<String> {
        let mut chunk = [0; 4096];
        while let Ok(count) = pipe.read(&mut chunk) {
            if count == 0 {
                self.is_closed = true;
                break;
            }
            self.bytes.extend_from_slice(&chunk[..count]);
        }
        let mut lines = Vec::new();
        while let Some(end) = self.bytes.iter().position(|&byte| byte == b'\n') {
            let line: Vec<u8> = self.bytes.drain(..=end).collect();
            lines.push(String::from_utf8_lossy(&line[..end]).into_owned());
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::LineBuffer;
    use std::io::Write;

    #[test]
    fn lines_come_whole_and_the_end_of_the_writer_is_known() {
        let (mut reader, mut writer) = std::os::unix::net::UnixStream::pair().unwrap();
        reader.set_nonblocking(true).unwrap();
        let mut buffer = LineBuffer::default();
        writer.write_all(b"one\ntw").unwrap();
        assert_eq!((buffer.read(&mut reader), buffer.is_closed), (vec!["one".to_string()], false));
        writer.write_all(b"o\n").unwrap();
        drop(writer);
        assert_eq!((buffer.read(&mut reader), buffer.is_closed), (vec!["two".to_string()], true));
    }
}
