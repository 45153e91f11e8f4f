//! GeoTIFF: grids as hydrographic offices publish them.

use std::io::{self, Read, Seek, SeekFrom};

use flate2::read::ZlibDecoder;
use tiff::ColorType;
use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use crate::grid::{Block, Header, MOST_ON_A_SIDE, Packing, check_square};
use crate::grid_cells::Cells;
use crate::grid_tiff_metadata::{Keys, LONGEST_TEXT, TiffMetadata, refuse, short_tag};
use crate::{DepthUnit, Grid, GridDeclaration, GridKind, Invalid, Reading, Unread};

/// Most bytes of a block of an image, decoded.
const MOST_BYTES: f64 = 1e9;
/// Most strips or tiles of an image.
const MOST_BLOCKS: u64 = 1 << 24;
/// Compressions by deflate, registered and older.
const DEFLATE: [u16; 2] = [8, 32_946];
/// Metadata as GDAL writes it.
const GDAL_METADATA: Tag = Tag::Unknown(42112);

impl Grid {
    /// Reads a GeoTIFF of one band, its rows from north to south. Its EPSG code need not be declared. Scale,
    /// offset, unit and vertical datum follow its metadata and keys.
    ///
    /// # Errors
    /// A file that is not a TIFF of one band, or damaged; a grid that is rotated, or whose cells are not
    /// square; a CRS that is neither stated nor declared, or stated otherwise than declared; an unknown unit,
    /// or not the declared one; as [`Grid::from_ascii`].
    pub fn from_tiff(
        source: impl Read + Seek,
        declared: &GridDeclaration,
        reading: &Reading,
    ) -> Result<Self, Unread> {
        let mut limits = Limits::default();
        let most = reading.bytes.clamp(LONGEST_TEXT, MOST_BYTES) as usize;
        (limits.decoding_buffer_size, limits.intermediate_buffer_size) = (most, most);
        let mut decoder = Decoder::new(source).map_err(refuse)?.with_limits(limits);
        let (columns, rows) = decoder.dimensions().map_err(refuse)?;
        let bits = bits(&mut decoder)?;
        let keys = Keys::read(&mut decoder)?;
        let crs = keys.crs(declared.crs.as_ref())?;
        let header = header(&mut decoder, &keys, [columns, rows])?;
        let packing = packing(&mut decoder, &keys, declared, bits)?;
        let cells = Cells::new(header, crs, packing, declared, reading)?;
        let blocks = Blocks::of(&mut decoder, [columns, rows])?;
        // Decoded, and about as much before decoding.
        let size = f64::from(blocks.size[0]) * f64::from(blocks.size[1]);
        cells.check_memory(size * f64::from(bits) / 8.0 * 2.0)?;
        let sums = Checksums::of(&mut decoder, size as u64 * u64::from(bits).div_ceil(8))?;
        cells.read(blocks.all(), |block| {
            let index = blocks.index(block);
            sums.check(decoder.inner(), index)?;
            numbers(decoder.read_chunk(index).map_err(refuse)?).map_err(Unread::from)
        })
    }
}

/// Where the deflated blocks are, each with a checksum at its end: the library reads them up to their last number.
struct Checksums {
    /// Position and length of each block in the file.
    blocks: Vec<(u64, u64)>,
    /// Bytes of a block, decoded.
    size: u64,
}

impl Checksums {
    fn of<R: Read + Seek>(decoder: &mut Decoder<R>, size: u64) -> Result<Self, Invalid> {
        let tags = match decoder.get_chunk_type() {
            ChunkType::Strip => [Tag::StripOffsets, Tag::StripByteCounts],
            ChunkType::Tile => [Tag::TileOffsets, Tag::TileByteCounts],
        };
        let kind: Option<u16> = decoder.find_tag_unsigned(Tag::Compression).map_err(refuse)?;
        let mut blocks = Vec::new();
        if kind.is_some_and(|kind| DEFLATE.contains(&kind)) {
            let [starts, lengths] = tags.map(|tag| decoder.find_tag_unsigned_vec(tag).map_err(refuse));
            blocks = starts?.unwrap_or_default().into_iter().zip(lengths?.unwrap_or_default()).collect();
        }
        Ok(Self { blocks, size })
    }

    fn check(&self, source: &mut (impl Read + Seek), index: u32) -> Result<(), Invalid> {
        let Some((start, length)) = self.blocks.get(index as usize) else { return Ok(()) };
        let read = source.seek(SeekFrom::Start(*start)).and_then(|_| {
            let block = ZlibDecoder::new(source.take(*length));
            io::copy(&mut block.take(self.size + 1), &mut io::sink())
        });
        read.map(drop).map_err(|error| refuse(error.into()))
    }
}

/// Bits of a number, of which there is one per pixel.
fn bits<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<u8, Invalid> {
    match decoder.colortype().map_err(refuse)? {
        ColorType::Gray(bits) => Ok(bits),
        band => {
            let remedy = "write one band, for instance with `gdal_translate -b 1`";
            Err(Invalid::new("GeoTIFF", format!("{band:?}"), "one band of numbers", remedy))
        }
    }
}

/// The encoding of the numbers by metadata, tags and keys.
fn packing<R: Read + Seek>(
    decoder: &mut Decoder<R>,
    keys: &Keys,
    declared: &GridDeclaration,
    bits: u8,
) -> Result<Packing, Invalid> {
    let text = |value: tiff::decoder::ifd::Value| value.into_string().map_err(refuse);
    let metadata = short_tag(decoder, GDAL_METADATA)?.map(text).transpose()?;
    let metadata = TiffMetadata::read(metadata.as_deref().unwrap_or_default())?;
    metadata.check_direction(declared.kind)?;
    let format: Option<Vec<u16>> = decoder.find_tag_unsigned_vec(Tag::SampleFormat).map_err(refuse)?;
    let is_single = bits == 32 && format.is_some_and(|format| format.first() == Some(&3));
    let no_data = short_tag(decoder, Tag::GdalNodata)?.map(text).transpose()?;
    let no_data = no_data.as_deref().map(|text| no_data_of(text, is_single)).transpose()?;
    let unit = match declared.kind {
        GridKind::LandMask => None,
        _ => same(metadata.unit()?, keys.unit()?)?,
    };
    Ok(Packing {
        scale: metadata.number("scale")?.unwrap_or(1.0),
        offset: metadata.number("offset")?.unwrap_or(0.0),
        unit,
        datum: keys.datum().or_else(|| metadata.datum()),
        missing: no_data,
    })
}

/// The number that means no data, rounded like a file of single precision if `is_single`.
fn no_data_of(text: &str, is_single: bool) -> Result<f64, Invalid> {
    let text = text.trim_matches(['\0', ' ']);
    match text.parse::<f64>() {
        Ok(number) if is_single => Ok(f64::from(number as f32)),
        Ok(number) => Ok(number),
        Err(_) => {
            let quoted = format!("`{}`", refusal::foreign(text));
            let remedy = "write it again, for instance with `gdal_edit.py -a_nodata -9999`";
            Err(Invalid::new("GDAL_NODATA", quoted, "a number", remedy))
        }
    }
}

/// The unit, if both sources that state one agree.
fn same(metadata: Option<DepthUnit>, keys: Option<DepthUnit>) -> Result<Option<DepthUnit>, Invalid> {
    match (metadata, keys) {
        (Some(one), Some(other)) if one != other => Err(Invalid::new(
            "UNITTYPE",
            format!("`{}`", one.name()),
            format!("`{}`, as the file's vertical system says", other.name()),
            "correct one of them in the file",
        )),
        (one, other) => Ok(one.or(other)),
    }
}

/// The position of the cells.
fn header<R: Read + Seek>(
    decoder: &mut Decoder<R>,
    keys: &Keys,
    [columns, rows]: [u32; 2],
) -> Result<Header, Invalid> {
    let scale = decoder.get_tag_f64_vec(Tag::ModelPixelScaleTag);
    let point = decoder.get_tag_f64_vec(Tag::ModelTiepointTag);
    let (Ok([width, height, ..]), Ok([column, row, _, x, y, _])) = (scale.as_deref(), point.as_deref())
    else {
        return Err(Invalid::new(
            "GeoTIFF",
            "no scale with one tie point",
            "a grid along the axes of its system",
            "straighten it, for instance with `gdalwarp`",
        ));
    };
    if [columns, rows].iter().any(|side| !(1..=MOST_ON_A_SIDE).contains(&(*side as usize))) {
        let expected = format!("1 to {MOST_ON_A_SIDE} on a side");
        return Err(Invalid::new(
            "GeoTIFF",
            format!("{columns} × {rows} cells"),
            expected,
            "cut it to the area",
        ));
    }
    let cell = check_square(*width, *height)?;
    let half = if keys.is_point() { 0.5 } else { 0.0 };
    let [west, north] = [x - cell * (column + half), y + cell * (row + half)];
    let corner = [west, north - cell * f64::from(rows)];
    Ok(Header { columns: columns as usize, rows: rows as usize, corner, cell })
}

/// The strips or tiles of an image.
#[derive(Clone, Copy)]
struct Blocks {
    /// Columns and rows of the image, and of a block.
    image: [u32; 2],
    size: [u32; 2],
    /// Number of blocks across and down.
    count: [u32; 2],
}

impl Blocks {
    fn of<R: Read + Seek>(decoder: &mut Decoder<R>, image: [u32; 2]) -> Result<Self, Invalid> {
        let (columns, rows) = decoder.chunk_dimensions();
        let size = match decoder.get_chunk_type() {
            ChunkType::Strip => [image[0], rows.min(image[1])],
            ChunkType::Tile => [columns, rows],
        };
        if size.contains(&0) {
            let blocks = format!("blocks of {columns} × {rows}");
            return Err(Invalid::new("GeoTIFF", blocks, "strips or tiles with cells", "export it again"));
        }
        let count = [0, 1].map(|k: usize| image[k].div_ceil(size[k]));
        let all = u64::from(count[0]) * u64::from(count[1]);
        if all > MOST_BLOCKS {
            let expected = format!("at most {MOST_BLOCKS}");
            return Err(Invalid::new(
                "GeoTIFF",
                format!("{all} strips or tiles"),
                expected,
                "export it in larger ones",
            ));
        }
        Ok(Self { image, size, count })
    }

    /// All of them, from north to south.
    fn all(self) -> impl Iterator<Item = Block> + Clone {
        let along = move |k: usize, index: u32| {
            let start = index * self.size[k];
            start..start.saturating_add(self.size[k]).min(self.image[k])
        };
        let wide = |range: std::ops::Range<u32>| range.start as usize..range.end as usize;
        (0..self.count[1]).flat_map(move |down| {
            let rows = along(1, down);
            let from_south = self.image[1] - rows.end..self.image[1] - rows.start;
            (0..self.count[0]).map(move |across| [wide(along(0, across)), wide(from_south.clone())])
        })
    }

    /// The index of a block.
    fn index(self, [columns, rows]: &Block) -> u32 {
        let row = self.image[1] as usize - rows.end;
        let [across, down] = [columns.start / self.size[0] as usize, row / self.size[1] as usize];
        down as u32 * self.count[0] + across as u32
    }
}

fn numbers(block: DecodingResult) -> Result<Box<dyn Iterator<Item = f64>>, Invalid> {
    Ok(match block {
        DecodingResult::U8(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::I8(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::U16(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::I16(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::U32(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::I32(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::F32(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::F64(all) => Box::new(all.into_iter()),
        _ => {
            let remedy = "write it as Float32, for instance with `gdal_translate -ot Float32`";
            let expected = "integers of 8 to 32 bits, or numbers of 32 or 64 bits";
            return Err(Invalid::new("GeoTIFF", "numbers of another width", expected, remedy));
        }
    })
}
