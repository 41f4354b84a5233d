mod messages;
mod round_trip;
mod samples;
