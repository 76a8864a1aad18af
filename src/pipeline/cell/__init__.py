"""One cell circuit for every chemistry: records, compiled functions of SOC, and the algebra of the circuit."""
