//! Layout hashes: what two processes must agree on before they exchange a sample.
//!
//! iceoryx2 compares type name, size and alignment only; two swapped fields of equal size attach
//! and are read as garbage. The hash covers field names, types and offsets, recursively.

use crate::FieldInfo;

/// A type whose memory layout has a hash: a primitive, an array, or a record made by `record!`.
pub trait Layout {
    /// CRC-32 over names, types and offsets.
    const HASH: u32;
    /// The type as text: `float64`, `float64[3]`, `Header` (ROS 1 message spelling, which the
    /// recording uses).
    const ROS: &'static str;
    /// Number of elements when the type is an array, else 0.
    const LENGTH: usize = 0;
}

/// A padding-free struct with documented fields.
pub trait Record: Layout + Sized {
    /// Name of the struct, which is also the schema's in a recording.
    const NAME: &'static str;
    /// One row per field, in the order of memory; offsets are contiguous.
    const FIELDS: &'static [FieldInfo];
}

macro_rules! primitive {
    ($($ty:ty => $ros:literal),*) => { $(
        impl Layout for $ty {
            const HASH: u32 = layout_hash(0, $ros.as_bytes());
            const ROS: &'static str = $ros;
        }
    )* };
}
primitive!(u16 => "uint16", u32 => "uint32", u64 => "uint64", f64 => "float64");

impl<T: Layout, const N: usize> Layout for [T; N] {
    const HASH: u32 = layout_hash(T::HASH, &(N as u32).to_le_bytes());
    const ROS: &'static str = T::ROS;
    const LENGTH: usize = N;
}

/// CRC-32 (IEEE) of `bytes`, continued from the CRC `seed` (0 to begin). `const`, because layout
/// hashes are constants; [`crc32`](crate::crc32) is the fast one for payloads.
#[must_use]
pub const fn layout_hash(seed: u32, bytes: &[u8]) -> u32 {
    let mut crc = !seed;
    let mut i = 0;
    while i < bytes.len() {
        crc ^= bytes[i] as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 };
            bit += 1;
        }
        i += 1;
    }
    !crc
}

/// Declares a record: the struct, its padding check, its layout hash and its rows of the interface
/// control document.
macro_rules! record {
    ($(#[$doc:meta])* $name:ident { $($field:ident : $ty:ty, $unit:literal, $frame:literal, $what:literal;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[derive(zerocopy::FromBytes, zerocopy::IntoBytes, zerocopy::Immutable, zerocopy::KnownLayout)]
        #[cfg_attr(feature = "iceoryx2", derive(iceoryx2::prelude::ZeroCopySend))]
        #[repr(C)]
        pub struct $name {
            $(#[doc = concat!($what, " \\[", $unit, "\\], ", $frame)] pub $field: $ty,)*
        }
        impl $crate::Layout for $name {
            const HASH: u32 = {
                let mut hash = $crate::layout_hash(0, stringify!($name).as_bytes());
                $(
                    hash = $crate::layout_hash(hash, stringify!($field).as_bytes());
                    hash = $crate::layout_hash(hash, &<$ty as $crate::Layout>::HASH.to_le_bytes());
                    hash = $crate::layout_hash(hash, &(core::mem::offset_of!($name, $field) as u32).to_le_bytes());
                )*
                hash
            };
            const ROS: &'static str = stringify!($name);
        }
        impl $crate::Record for $name {
            const NAME: &'static str = stringify!($name);
            const FIELDS: &'static [$crate::FieldInfo] = &[$($crate::FieldInfo {
                name: stringify!($field),
                ros: <$ty as $crate::Layout>::ROS,
                length: <$ty as $crate::Layout>::LENGTH,
                unit: $unit,
                frame: $frame,
                what: $what,
                offset: core::mem::offset_of!($name, $field),
                size: core::mem::size_of::<$ty>(),
            },)*];
        }
        // Eight-byte multiples keep a queue of samples aligned without padding between them.
        const _: () = assert!(core::mem::size_of::<$name>() % 8 == 0, "pad the record to a multiple of 8 bytes by a named field");
    };
}
pub(crate) use record;

#[cfg(test)]
mod tests {
    use crate::{Estimate, FieldInfo, Header, IdentifiedMode, Innovation, Layout, Record, TOPICS, layout_hash};

    /// Records that differ in one thing each.
    macro_rules! build {
        ($build:ident { $($field:ident : $ty:ty, $unit:literal;)* }) => {
            mod $build {
                #[cfg(feature = "iceoryx2")]
                use iceoryx2::prelude::ZeroCopySend;
                crate::layout::record! {
                    /// A record of one build.
                    Probe { $($field : $ty, $unit, "-", "a field";)* }
                }
            }
        };
    }
    build!(original { first: f64, "m"; second: f64, "m"; third: [f64; 3], "m"; small: u32, "-"; other: u32, "-"; });
    build!(swapped { second: f64, "m"; first: f64, "m"; third: [f64; 3], "m"; small: u32, "-"; other: u32, "-"; });
    build!(swapped_small { first: f64, "m"; second: f64, "m"; third: [f64; 3], "m"; other: u32, "-"; small: u32, "-"; });
    build!(renamed { first: f64, "m"; seconds: f64, "m"; third: [f64; 3], "m"; small: u32, "-"; other: u32, "-"; });
    build!(retyped { first: f64, "m"; second: u64, "m"; third: [f64; 3], "m"; small: u32, "-"; other: u32, "-"; });
    build!(regrouped { first: f64, "m"; second: [f64; 3], "m"; third: f64, "m"; small: u32, "-"; other: u32, "-"; });
    build!(other_unit { first: f64, "km"; second: f64, "m"; third: [f64; 3], "m"; small: u32, "-"; other: u32, "-"; });

    #[test]
    fn swapping_two_fields_of_equal_size_changes_the_hash_and_nothing_that_the_transport_compares() {
        assert_eq!(size_of::<original::Probe>(), size_of::<swapped::Probe>());
        assert_eq!(align_of::<original::Probe>(), align_of::<swapped::Probe>());
        assert_eq!(original::Probe::NAME, swapped::Probe::NAME);
        assert_ne!(original::Probe::HASH, swapped::Probe::HASH);
        assert_ne!(original::Probe::HASH, swapped_small::Probe::HASH);
    }

    #[test]
    fn another_name_type_or_grouping_of_a_field_changes_the_hash_and_documentation_does_not() {
        assert_ne!(original::Probe::HASH, renamed::Probe::HASH);
        assert_ne!(original::Probe::HASH, retyped::Probe::HASH);
        assert_ne!(original::Probe::HASH, regrouped::Probe::HASH);
        assert_eq!(original::Probe::HASH, other_unit::Probe::HASH);
    }

    #[test]
    fn the_hash_is_the_standard_crc_32() {
        assert_eq!(layout_hash(0, b"123456789"), 0xCBF4_3926); // the published check value of CRC-32/ISO-HDLC
        assert_eq!(layout_hash(layout_hash(0, b"1234"), b"56789"), 0xCBF4_3926);
        assert_eq!(crate::crc32(b"123456789"), 0xCBF4_3926);
    }

    /// By the rule that `obsid icd` lets a reader apply.
    fn documented_hash(record: &str, fields: &[FieldInfo]) -> u32 {
        fields.iter().fold(layout_hash(0, record.as_bytes()), |hash, field| {
            let element = match field.ros {
                Header::NAME => documented_hash(Header::NAME, Header::FIELDS),
                Innovation::NAME => documented_hash(Innovation::NAME, Innovation::FIELDS),
                Estimate::NAME => documented_hash(Estimate::NAME, Estimate::FIELDS),
                IdentifiedMode::NAME => documented_hash(IdentifiedMode::NAME, IdentifiedMode::FIELDS),
                primitive => layout_hash(0, primitive.as_bytes()),
            };
            let of_type = match (field.length, field.ros) {
                (0, _) => element,
                // An array of arrays, which the document shows by its size.
                (rows, "float64") if field.size > rows * 8 => {
                    let columns = (field.size / (rows * 8)) as u32;
                    layout_hash(layout_hash(element, &columns.to_le_bytes()), &(rows as u32).to_le_bytes())
                }
                (count, _) => layout_hash(element, &(count as u32).to_le_bytes()),
            };
            let hash = layout_hash(hash, field.name.as_bytes());
            let hash = layout_hash(hash, &of_type.to_le_bytes());
            layout_hash(hash, &(field.offset as u32).to_le_bytes())
        })
    }

    #[test]
    fn every_hash_follows_from_the_documented_fields() {
        for info in TOPICS {
            assert_eq!(documented_hash(info.record, info.fields), info.layout, "{}", info.name);
        }
    }
}
