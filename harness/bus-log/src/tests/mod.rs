mod blf;
mod channels;
mod damaged;
mod mdf4;
mod messages;
mod round_trip;
mod samples;
