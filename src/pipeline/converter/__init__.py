"""The converters between panel and battery: boost to the bus, buck from the bus to the battery."""
