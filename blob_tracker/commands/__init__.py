"""What `python3 -m blob_tracker` starts, one module or folder for each command."""

# What brings ROS where it is not installed: wheels of it.
INSTALL_ROS = 'python3 -m pip install "ros-jazzy-rclpy[fastrtps]" ros-jazzy-common-interfaces'
