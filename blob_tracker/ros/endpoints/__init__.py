"""What publishes and what listens: topics, bags, the pairing of messages, and their QoS."""
