"""Driver of the pneumatic robot: a Festo terminal over Modbus TCP, and an emulator of one."""
