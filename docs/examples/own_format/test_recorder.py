from format_contract import TRAVEL, Example, FormatContract


def write(file):  # the contract's travel, at 10 kHz
    file.write_bytes(b"ACME" + (10_000).to_bytes(4, "little") + TRAVEL.astype("<f4").tobytes())


class TestAcme(FormatContract):
    example = Example("a.acme", {"time_unit": "ms"}, "travel", write)
