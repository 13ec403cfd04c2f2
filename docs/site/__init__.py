"""The site: guides, a page a command and a topic of Python, models, pictures made when it is built, tutorials."""
