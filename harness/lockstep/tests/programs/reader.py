"""A controller with pyserial: reads a gyro, tells a base twice a second what it knows."""

import sys
import time

import serial

gyro = serial.Serial(sys.argv[1], 115200, timeout=0.1)
base = serial.Serial(sys.argv[2], 115200, timeout=0)
start = time.monotonic()
heading = 0.0
samples = 0
while True:
    line = gyro.readline()
    if not line:
        continue
    heading += float(line) / 100
    samples += 1
    if samples % 2 == 0:
        base.write(b"%d %.4f %.9f\n" % (samples, heading, time.monotonic() - start))
    if samples % 1000 == 0:
        time.sleep(0.0005)
