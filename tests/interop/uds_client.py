"""A tester of the heater of docs/uds.md, by the packages udsoncan and can-isotp. Once everything was as it expects, it writes a
setpoint of 77."""

import os
import sys
import time
import traceback

import can
import isotp
import udsoncan
from udsoncan import services
from udsoncan.client import Client
from udsoncan.connections import PythonIsoTpConnection

channel, fd = sys.argv[1], sys.argv[2] == "fd"
bus = can.Bus(interface="socketcan", channel=channel, fd=fd)
params = {"tx_padding": 0xAA, "blocksize": 2, "stmin": 1, "blocking_send": False}
if fd:
    params |= {"tx_data_length": 64, "can_fd": True, "bitrate_switch": True}
    mode = isotp.AddressingMode.NormalFixed_29bits
    address = isotp.Address(mode, source_address=0xF1, target_address=0x10)
else:
    address = isotp.Address(isotp.AddressingMode.Normal_11bits, txid=0x7E0, rxid=0x7E8)
stack = isotp.CanStack(bus=bus, address=address, params=params)

config = dict(udsoncan.configs.default_client_config)
config["data_identifiers"] = {0xF190: udsoncan.AsciiCodec(17), 0x0100: ">h", 0x0101: "B"}
config["security_algo"] = lambda level, seed, params=None: bytes(byte ^ 0x5A for byte in seed)


def refused(code, request):
    try:
        request()
    except udsoncan.exceptions.NegativeResponseException as error:
        assert error.response.code == code, (hex(error.response.code), hex(code))
    else:
        raise AssertionError(f"{hex(code)} was expected")


def talk(client):
    read = client.read_data_by_identifier
    assert read(0xF190).service_data.values[0xF190] == "WHEATER0000000042"
    # A request in several frames, and so is the response.
    values = read([0xF190, 0x0101, 0x0100, 0xF190, 0x0101]).service_data.values
    assert values[0x0101] == (60,) and values[0x0100][0] >= 200, values
    refused(0x31, lambda: client.send_request(udsoncan.Request(services.ReadDataByIdentifier, data=b"\x12\x34")))
    refused(0x7F, lambda: client.write_data_by_identifier(0x0101, 70))

    session = client.change_session(services.DiagnosticSessionControl.Session.extendedDiagnosticSession)
    assert session.service_data.p2_server_max == 0.05 and session.service_data.p2_star_server_max == 5
    refused(0x33, lambda: client.write_data_by_identifier(0x0101, 70))
    refused(0x35, lambda: client.send_key(2, bytes(4)) if client.request_seed(1) else None)
    client.unlock_security_access(1)
    client.write_data_by_identifier(0x0101, 75)
    assert read(0x0101).service_data.values[0x0101] == (75,)
    refused(0x31, lambda: client.write_data_by_identifier(0x0101, 95))

    codes = {dtc.id: dtc for dtc in client.get_supported_dtc().service_data.dtcs}
    assert sorted(codes) == [0x0A0F16, 0x123456]
    status = codes[0x123456].status
    assert status.test_failed and status.pending and status.confirmed and status.warning_indicator_requested
    assert not status.test_not_completed_since_last_clear
    assert client.get_number_of_dtc_by_status_mask(0x08).service_data.dtc_count == 1
    (failed,) = client.get_dtc_by_status_mask(0x01).service_data.dtcs
    assert failed.id == 0x123456
    client.control_dtc_setting(services.ControlDTCSetting.SettingType.off)
    client.clear_dtc(0xFFFFFF)
    assert client.get_dtc_by_status_mask(0x01).service_data.dtcs == []
    client.control_dtc_setting(services.ControlDTCSetting.SettingType.on)

    refused(0x24, lambda: client.get_routine_result(0x0203))
    client.start_routine(0x0203)
    assert client.get_routine_result(0x0203).service_data.routine_status_record == b"\x01"
    client.stop_routine(0x0203)

    with client.suppress_positive_response:
        client.tester_present()
    everything = udsoncan.CommunicationType(subnet=0, normal_msg=True)
    client.communication_control(services.CommunicationControl.ControlType.enableRxAndDisableTx, everything)
    client.communication_control(services.CommunicationControl.ControlType.enableRxAndTx, everything)

    client.ecu_reset(services.ECUReset.ResetType.hardReset)
    time.sleep(0.3)
    assert read(0x0101).service_data.values[0x0101] == (60,)
    client.change_session(3)
    client.unlock_security_access(1)
    client.write_data_by_identifier(0x0101, 77)

try:
    with Client(PythonIsoTpConnection(stack), config=config) as client:
        talk(client)
except Exception:
    traceback.print_exc(limit=1)
    sys.stderr.flush()
    os._exit(1)
while True:
    time.sleep(1)
