"""A display on a J1939 bus, by the package can-j1939: hears the fault codes that the engine tells everybody, which are longer
than a frame, and sends them back to the engine alone."""

import sys
import time

import j1939

ENGINE, DISPLAY = 0, 40
FAULT_CODES = 65226

ecu = j1939.ElectronicControlUnit(max_cmdt_packets=2)
ecu.connect(interface="socketcan", channel=sys.argv[1])
name = j1939.Name(
    arbitrary_address_capable=0,
    industry_group=j1939.Name.IndustryGroup.Industrial,
    vehicle_system_instance=0,
    vehicle_system=0,
    function=60,
    function_instance=0,
    ecu_instance=0,
    manufacturer_code=666,
    identity_number=1234567,
)
display = j1939.ControllerApplication(name, DISPLAY, bypass_address_claim=True)
ecu.add_ca(controller_application=display)


def heard(priority, group, source, timestamp, data):
    if (group, source) == (FAULT_CODES, ENGINE):
        display.send_pgn(0, 0xEF, ENGINE, 6, list(data))


display.subscribe(heard)
display.start()
while True:
    time.sleep(1)
