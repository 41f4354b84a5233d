//! The server of SDO transfers (CiA 301, 7.2.4): expedited and in segments.

use super::abort::Abort;
use super::objects::{Application, Objects};

/// Most bytes of a transfer. Assumption: names and parameter sets are shorter; firmware comes in blocks.
const BYTES_MAX: usize = 4096;
pub(super) const SEGMENT: usize = 7;
pub(super) const ABORT: u8 = 0x80;

pub(super) type Words = [u8; 8];

/// The server, with at most one transfer.
#[derive(Debug, Clone, Default)]
pub(super) struct Server {
    transfer: Option<Transfer>,
}

#[derive(Debug, Clone)]
struct Transfer {
    object: (u16, u8),
    data: Vec<u8>,
    toggle: u8,
    way: Way,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// To the master, with the position of the next segment.
    Up(usize),
    /// From the master, with the number of bytes that it announced.
    Down(Option<usize>),
}

/// The objects, and the application behind them.
pub(super) struct Store<'a> {
    pub(super) objects: &'a mut Objects,
    pub(super) application: &'a mut dyn Application,
}

impl Store<'_> {
    fn write(&mut self, object: (u16, u8), bytes: &[u8]) -> Result<(), Abort> {
        self.objects.write(object, bytes, self.application)
    }
}

/// A frame with this command for an object.
pub(super) fn words(command: u8, (index, sub): (u16, u8), data: [u8; 4]) -> Words {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = data;
    [command, low, high, sub, a, b, c, d]
}

/// The object that a frame names.
pub(super) const fn object(frame: &Words) -> (u16, u8) {
    (u16::from_le_bytes([frame[1], frame[2]]), frame[3])
}

/// The last four bytes.
pub(super) const fn data(frame: &Words) -> [u8; 4] {
    [frame[4], frame[5], frame[6], frame[7]]
}

/// A segment: its bytes, and whether it is the last one.
pub(super) fn segment(command: u8, part: &[u8], is_last: bool) -> Words {
    let mut frame = [0; 8];
    frame[1..=part.len()].copy_from_slice(part);
    frame[0] = command | ((SEGMENT - part.len()) as u8) << 1 | u8::from(is_last);
    frame
}

impl Server {
    /// The answer to a request.
    pub(super) fn request(&mut self, frame: &Words, store: &mut Store<'_>) -> Option<Words> {
        let object = match frame[0] >> 5 {
            0 | 3 => self.transfer.as_ref().map_or((0, 0), |transfer| transfer.object),
            _ => object(frame),
        };
        let answer = match frame[0] >> 5 {
            0 => self.down_segment(frame, store),
            1 => self.down(frame, store),
            2 => self.up(object, store),
            3 => self.up_segment(frame),
            4 => {
                self.transfer = None;
                return None;
            }
            _ => Err(Abort::COMMAND),
        };
        Some(answer.unwrap_or_else(|why| {
            self.transfer = None;
            words(ABORT, object, why.0.to_le_bytes())
        }))
    }

    fn down(&mut self, frame: &Words, store: &mut Store<'_>) -> Result<Words, Abort> {
        self.transfer = None;
        let (object, data) = (object(frame), data(frame));
        let done = words(0x60, object, [0; 4]);
        let (is_expedited, is_sized) = (frame[0] & 2 != 0, frame[0] & 1 != 0);
        if is_expedited {
            let length = match is_sized {
                true => 4 - usize::from(frame[0] >> 2 & 3),
                false => store.objects.length(object)?.min(4),
            };
            store.write(object, &data[..length])?;
            return Ok(done);
        }
        store.objects.length(object)?;
        let size = is_sized.then(|| u32::from_le_bytes(data) as usize);
        if size.is_some_and(|size| size > BYTES_MAX) {
            return Err(Abort::MEMORY);
        }
        let way = Way::Down(size);
        self.transfer = Some(Transfer { object, data: Vec::new(), toggle: 0, way });
        Ok(done)
    }

    fn down_segment(&mut self, frame: &Words, store: &mut Store<'_>) -> Result<Words, Abort> {
        let transfer = self.transfer.as_mut().ok_or(Abort::COMMAND)?;
        let Way::Down(size) = transfer.way else { return Err(Abort::COMMAND) };
        let toggle = frame[0] & 0x10;
        if toggle != transfer.toggle {
            return Err(Abort::TOGGLE);
        }
        transfer.toggle ^= 0x10;
        let length = SEGMENT - usize::from(frame[0] >> 1 & 7);
        transfer.data.extend_from_slice(&frame[1..=length]);
        if transfer.data.len() > size.unwrap_or(BYTES_MAX) {
            return Err(if size.is_some() { Abort::TOO_LONG } else { Abort::MEMORY });
        }
        if frame[0] & 1 != 0 {
            let Some(whole) = self.transfer.take() else { return Err(Abort::COMMAND) };
            if size.is_some_and(|size| whole.data.len() < size) {
                return Err(Abort::TOO_SHORT);
            }
            store.write(whole.object, &whole.data)?;
        }
        Ok([0x20 | toggle, 0, 0, 0, 0, 0, 0, 0])
    }

    fn up(&mut self, object: (u16, u8), store: &mut Store<'_>) -> Result<Words, Abort> {
        self.transfer = None;
        let data = store.objects.read(object, store.application)?;
        if let (1..=4, Ok(free)) = (data.len(), u8::try_from(4usize.saturating_sub(data.len()))) {
            let mut four = [0; 4];
            four[..data.len()].copy_from_slice(&data);
            return Ok(words(0x43 | free << 2, object, four));
        }
        let size = (data.len() as u32).to_le_bytes();
        self.transfer = Some(Transfer { object, data, toggle: 0, way: Way::Up(0) });
        Ok(words(0x41, object, size))
    }

    fn up_segment(&mut self, frame: &Words) -> Result<Words, Abort> {
        let transfer = self.transfer.as_mut().ok_or(Abort::COMMAND)?;
        let Way::Up(at) = transfer.way else { return Err(Abort::COMMAND) };
        let toggle = frame[0] & 0x10;
        if toggle != transfer.toggle {
            return Err(Abort::TOGGLE);
        }
        transfer.toggle ^= 0x10;
        let end = transfer.data.len().min(at + SEGMENT);
        let is_last = end == transfer.data.len();
        let answer = segment(toggle, &transfer.data[at..end], is_last);
        transfer.way = Way::Up(end);
        if is_last {
            self.transfer = None;
        }
        Ok(answer)
    }
}
