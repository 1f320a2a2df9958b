//! Samples that carry a checksum of what they say, beside the one of their transport: they are kept
//! in checkpoints and folded long after they were received.

/// `sealed` and `is_intact` of a sample that begins with its header and its frame and ends with
/// `crc32` and a reserved word: CRC-32 (IEEE) over all between. In which frame it is sent is not
/// part of what it says.
macro_rules! sealed {
    ($name:ident) => {
        impl $name {
            fn sealed_bytes(&self) -> &[u8] {
                let bytes = zerocopy::IntoBytes::as_bytes(self);
                &bytes[size_of::<crate::Header>() + size_of::<u64>()..bytes.len() - size_of::<u64>()]
            }

            /// The same sample with `crc32` computed over what it says.
            #[must_use]
            pub fn sealed(mut self) -> Self {
                self.crc32 = crate::crc32(self.sealed_bytes());
                self
            }

            /// Whether `crc32` is that of what it says: false after any change behind
            #[doc = concat!("[`", stringify!($name), "::sealed`].")]
            #[must_use]
            pub fn is_intact(&self) -> bool {
                self.crc32 == crate::crc32(self.sealed_bytes())
            }
        }
    };
}
pub(crate) use sealed;
