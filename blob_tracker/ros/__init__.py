"""Messages to types and back, parameters, QoS, diagnostics: what knows ROS besides the nodes."""
