//! Chunks unpacked: never to more than they state, and a file never to more than real data are.

use super::bzip2;
use std::borrow::Cow;
use std::io::Read;

/// Bytes of one chunk.
const CHUNK_MAX: u64 = 256 << 20;
/// Bytes of all chunks: some, and some for every byte of the file.
const FILE_MAX: (u64, u64) = (64 << 20, 200);
/// Window of the levels up to 19, where the size of the content is not known to the writer.
const WINDOW_LOG_MIN: u32 = 23;

/// What the chunks of a file may still unpack to.
pub(super) struct Budget(u64);

impl Budget {
    /// For a file of `size` bytes.
    pub fn new(size: u64) -> Self {
        Budget(FILE_MAX.0.saturating_add(size.saturating_mul(FILE_MAX.1)))
    }

    /// The content of a chunk that states to be `size` bytes long.
    ///
    /// # Errors
    /// Why it is not unpacked.
    pub fn unpack<'a>(&mut self, compression: &str, packed: &'a [u8], size: u64) -> Result<Cow<'a, [u8]>, String> {
        if matches!(compression, "" | "none") {
            return Ok(Cow::Borrowed(packed));
        }
        if size > CHUNK_MAX || size > self.0 {
            return Err(format!("{} bytes state to unpack to {size}, which no recording does", packed.len()));
        }
        self.0 -= size;
        let limit = usize::try_from(size).map_err(|_| "a chunk larger than memory".to_string())?;
        let bytes = match compression {
            "lz4" => read(lz4_flex::frame::FrameDecoder::new(packed), size)?,
            "zstd" => unzstd(packed, size)?,
            "bz2" => bzip2::unpack(packed, limit)?,
            other => return Err(format!("compressed by `{other}`, which is not read (lz4, zstd and bz2 are)")),
        };
        if bytes.len() != limit {
            return Err(format!("a chunk of {} bytes states {size}", bytes.len()));
        }
        Ok(Cow::Owned(bytes))
    }
}

fn unzstd(packed: &[u8], size: u64) -> Result<Vec<u8>, String> {
    let mut decoder = zstd::Decoder::with_buffer(packed).map_err(|error| error.to_string())?;
    // A window beyond the content is memory that nothing needs.
    let window_log = size.max(1).next_power_of_two().ilog2().max(WINDOW_LOG_MIN);
    decoder.window_log_max(window_log).map_err(|error| error.to_string())?;
    read(decoder, size)
}

/// Grows with what is there: a stated size alone takes no memory.
fn read(from: impl Read, size: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    from.take(size + 1).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes)
}
