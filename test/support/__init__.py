"""What several tests use: processes, cameras, boards, and checks of statistics."""
