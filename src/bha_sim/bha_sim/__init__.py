"""The Bionic Handling Assistant in MuJoCo: nine bellows that are slow, soft and remember."""
